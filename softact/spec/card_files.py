"""Cards of the user's own: ``card: ./my_silicone.yaml`` is read in place, as a library card is."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from softact.errors import SpecError
from softact.files.document import Document, Place, dotted
from softact.materials import LAWS, Law
from softact.materials.cards import with_changes
from softact.nearest import nearest
from softact.spec.faults import validated
from softact.spec.kinds import read_as
from softact.units import show

SUFFIXES = (".yaml", ".yml")


def is_file(card: str) -> bool:
    """Whether what a spec or an option names is a file and no card of the library."""
    return card.lower().endswith(SUFFIXES)


def insert(source: Document, named: Iterable[Place]) -> list[str]:
    """Replace each material that names a card file by the file's content and its changes.

    named: places of the files' names. Returns a line for each fault of a card, with its own lines;
    where a card is wrong a material stands that is right, so that whatever else is wrong can be
    told beside it.
    """
    faults = []
    for here in named:
        place = here[:-1] if here[-1] == "card" else here
        value = source.value(place)
        changes = {k: v for k, v in value.items() if k != "card"} if isinstance(value, dict) else {}
        try:
            content = read_card(source.folder / source.value(here))
            if changes.get("law", content["law"]) != content["law"]:
                raise SpecError(f"the card is of law {content['law']}, not {changes['law']}")
            material: dict[str, Any] | Law = with_changes(content, changes)
        except SpecError as error:
            start = f"{source.where(here)}: {dotted(here)}"
            faults += [f"{start}: {line}" for line in error.lines]
            material = LAWS["neo_hookean"].model_validate({"c10": "1 MPa"})
        source.value(place[:-1])[place[-1]] = material
    return faults


def read_card(path: Path) -> dict[str, Any]:
    """Return what a card file holds, as ``card_data`` does for a card of the library.

    Its name is the file's where it has none. Raises SpecError with the file's lines.
    """
    card = read_as(path, "card")
    law = card.data.get("law")
    if law is None:
        raise SpecError(f"{card.name}: 'law' is missing; one of {', '.join(LAWS)}")
    if not isinstance(law, str) or law not in LAWS:
        where = card.where(("law",))
        raise SpecError(f"{where}: law: there is no law {show(law)}; {nearest(law, LAWS)}")
    card.data = {"name": path.stem, **card.data}
    validated(card, LAWS[law])
    return card.data
