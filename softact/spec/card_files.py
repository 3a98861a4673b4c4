"""Cards of the user's own: ``card: ./my_silicone.yaml`` is read in place, as a library card is."""

from pathlib import Path
from typing import Any

from pydantic import ValidationError

from softact.errors import SpecError
from softact.materials import LAWS
from softact.materials.cards import with_changes
from softact.spec import document
from softact.spec.choice import nearest
from softact.spec.document import Document, Place, dotted
from softact.spec.faults import fault_lines
from softact.units import show

SUFFIXES = (".yaml", ".yml")


def is_file(card: str) -> bool:
    """Whether what a spec or an option names is a file and no card of the library."""
    return card.lower().endswith(SUFFIXES)


def insert(source: Document, folder: Path) -> None:
    """Replace each material that names a card file by the file's content and its changes.

    folder: where relative paths count from. A card that is wrong is told with its own lines, all
    cards at once. Raises SpecError.
    """
    faults = []
    for place in _material_places(source.data):
        value = _at(source.data, place)
        card = value.get("card") if isinstance(value, dict) else value
        if not isinstance(card, str) or not is_file(card):
            continue
        changes = {k: v for k, v in value.items() if k != "card"} if isinstance(value, dict) else {}
        try:
            content = read_card(folder / Path(card).expanduser())
            if changes.get("law", content["law"]) != content["law"]:
                raise SpecError(f"the card is of law {content['law']}, not {changes['law']}")
        except SpecError as error:
            here = (*place, "card") if isinstance(value, dict) else place
            start = f"{source.where(here)}: {dotted(here)}"
            faults += [f"{start}: {line}" for line in error.lines]
            continue
        _at(source.data, place[:-1])[place[-1]] = with_changes(content, changes)
    if faults:
        raise SpecError(*faults)


def _material_places(data: dict[str, Any]) -> list[Place]:
    """Where a spec has materials; nothing where it is malformed, which is told later."""
    places: list[Place] = []
    if isinstance(data.get("materials"), dict):
        places += [("materials", region) for region in data["materials"]]
    if isinstance(data.get("layers"), list):
        layers = enumerate(data["layers"])
        places += [
            ("layers", i, "material")
            for i, la in layers
            if isinstance(la, dict) and "material" in la
        ]
    return places


def _at(data: Any, place: Place) -> Any:
    for key in place:
        data = data[key]
    return data


def read_card(path: Path) -> dict[str, Any]:
    """Return what a card file holds, as ``card_data`` does for a card of the library.

    Its name is the file's where it has none. Raises SpecError with the file's lines.
    """
    card = document.read(path)
    law = card.data.get("law")
    if law is None:
        raise SpecError(f"{card.name}: 'law' is missing; one of {', '.join(LAWS)}")
    if not isinstance(law, str) or law not in LAWS:
        where = card.where(("law",))
        raise SpecError(f"{where}: law: there is no law {show(law)}; {nearest(law, LAWS)}")
    content = {"name": path.stem, **card.data}
    try:
        LAWS[law].model_validate(content)
    except ValidationError as error:
        raise SpecError(*fault_lines(error, card, LAWS[law])) from None
    return content
