"""Material cards: softact/cards/*.yaml, one material per file, in the words of the spec."""

import copy
from functools import cache
from importlib.resources import files
from typing import Any

import yaml

from softact.errors import SpecError
from softact.materials.base import VOLUMETRIC, Law
from softact.materials.laws import LAWS
from softact.nearest import nearest


def card_names() -> tuple[str, ...]:
    """Return the names of all cards, sorted."""
    folder = files("softact") / "cards"
    return tuple(
        sorted(entry.name.removesuffix(".yaml") for entry in folder.iterdir()
               if entry.name.endswith(".yaml"))
    )  # fmt: skip


@cache
def _content(name: str) -> dict[str, Any]:
    text = (files("softact") / "cards" / f"{name}.yaml").read_text(encoding="utf-8")
    return yaml.safe_load(text)


def card_data(name: str) -> dict[str, Any]:
    """Return the mapping in a card's file, with its name. Raises SpecError for an unknown name."""
    if name not in card_names():
        raise SpecError(
            f"there is no material card '{name}'; {nearest(name, card_names())} "
            "(softact list materials shows them)"
        )
    return {"name": name, **copy.deepcopy(_content(name))}


def with_changes(card: dict[str, Any], changes: dict[str, Any]) -> dict[str, Any]:
    """Return a card's data with some replaced: a new compressibility replaces the card's."""
    if any(changes.get(key) is not None for key in VOLUMETRIC):
        card = {key: value for key, value in card.items() if key not in VOLUMETRIC}
    return {**card, **changes}


def load_card(name: str, **overrides: Any) -> Law:
    """Return the law of a card; ``overrides`` replace fields and are written as in a spec.

    Raises SpecError for an unknown card and pydantic's ValidationError for a wrong override.
    """
    return parse_material({"card": name, **overrides})


def parse_material(value: Any) -> Law:
    """Return the law that a spec's material means: a card's name, {card:, ...} or {law:, ...}.

    Raises SpecError for an unknown card or law and pydantic's ValidationError for its fields.
    """

    if isinstance(value, Law):
        return value
    if isinstance(value, str):
        value = {"card": value}
    if not isinstance(value, dict):
        raise SpecError(f"a material is the name of a card or a mapping, not '{value}'")
    data = dict(value)
    if "card" in data:
        base = card_data(data.pop("card"))
        if data.get("law", base["law"]) != base["law"]:
            raise SpecError(f"card '{base['name']}' is of law {base['law']}, not {data['law']}")
        data = with_changes(base, data)
    if "law" not in data:
        raise SpecError("a material needs 'card' or 'law'")
    law = data["law"]
    if law not in LAWS:
        raise SpecError(f"there is no law '{law}'; {nearest(law, LAWS)}")
    return LAWS[law].model_validate(data)
