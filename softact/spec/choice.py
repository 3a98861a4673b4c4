"""Fields whose model is looked up in a registry by what the spec says: geometries, materials."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from pydantic import BaseModel
from pydantic_core import core_schema

from softact.errors import SpecError
from softact.fields import fault, fault_at, given
from softact.geometry.base import Geometry
from softact.nearest import nearest
from softact.units import show

if TYPE_CHECKING:
    from softact.materials import Law


class Choice:
    """Base of the markers below: pydantic asks them for the schema of their field."""

    def model_for(self, data: Any) -> type[BaseModel] | None:
        """Return the model that ``data`` asks for, None where it asks for none that there is."""
        raise NotImplementedError

    def validate(self, data: Any) -> BaseModel:
        """Return ``data`` as an instance of its model."""
        raise NotImplementedError

    def dump(self, model: BaseModel, info: Any) -> dict[str, Any]:
        """Return the plain data of an instance, without what is not set."""
        return model.model_dump(mode=info.mode, exclude_none=True)

    def options(self) -> list[type[BaseModel]]:
        """Return every model that there is, for the JSON schema."""
        raise NotImplementedError

    def also(self) -> tuple[str, ...]:
        """Return keys that are known beside the fields of the model, and without one."""
        return ()

    def written_out(self, data: Any) -> Any:
        """Return a short form, such as the name of a card, as the mapping that it stands for."""
        return data

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> core_schema.CoreSchema:
        dump = core_schema.plain_serializer_function_ser_schema(self.dump, info_arg=True)
        return core_schema.no_info_plain_validator_function(self.validate, serialization=dump)

    def __get_pydantic_json_schema__(self, schema: Any, handler: Any) -> dict[str, Any]:
        options: list[core_schema.CoreSchema | tuple[core_schema.CoreSchema, str]] = [
            option.__pydantic_core_schema__ for option in self.options()
        ]
        return handler(core_schema.union_schema(options))


@dataclass(frozen=True)
class GeometryChoice(Choice):
    """A geometry: the key ``type`` says which.

    registry: returns name -> class. It is called late, since geometries import softact.
    """

    registry: Callable[[], Mapping[str, type[Geometry]]]

    def model_for(self, data: Any) -> type[Geometry] | None:
        """See ``Choice.model_for``."""
        kind = data.get("type") if isinstance(data, dict) else None
        return self.registry().get(kind) if isinstance(kind, str) else None

    def validate(self, data: Any) -> Geometry:
        """See ``Choice.validate``."""
        registry = self.registry()
        if isinstance(data, Geometry) and isinstance(data, tuple(registry.values())):
            return data
        if not isinstance(data, dict):
            names = ", ".join(registry)
            raise fault(f"{given(data)}; write a mapping with 'type' (one of {names}) and its keys")
        if "type" not in data:
            raise fault_at(("type",), f"missing; write one of: {', '.join(registry)}")
        if (model := self.model_for(data)) is None:
            kind = data["type"]
            raise fault_at(
                ("type",), f"there is no geometry {show(kind)}; {nearest(kind, registry)}"
            )
        return model.model_validate(data)

    def options(self) -> list[type[BaseModel]]:
        """See ``Choice.options``."""
        return list(self.registry().values())

    def also(self) -> tuple[str, ...]:
        """See ``Choice.also``."""
        return ("type",)


@dataclass(frozen=True)
class MaterialChoice(Choice):
    """A material: the name of a card, ``{card:, ...}`` or ``{law:, ...}``.

    layer: whether it is that of a thin layer, which not every law can be.
    """

    layer: bool = False

    def laws(self) -> Mapping[str, type[Law]]:
        """Return name -> class of the laws that fit here."""
        from softact.materials import LAWS

        # A thin layer's energy is that of a linear sheet, see softact.bodies.layer.Layer.
        return {"linear": LAWS["linear"]} if self.layer else LAWS

    def model_for(self, data: Any) -> type[Law] | None:
        """See ``Choice.model_for``."""
        from softact.materials import CARDS, card_data

        card = data if isinstance(data, str) else None
        law = None
        if isinstance(data, dict):
            card, law = data.get("card"), data.get("law")
        if law is None and isinstance(card, str) and card in CARDS:
            law = card_data(card)["law"]
        return self.laws().get(law) if isinstance(law, str) else None

    def validate(self, data: Any) -> Law:
        """See ``Choice.validate``."""
        from softact.materials import CARDS, Law, parse_material

        example = "write the name of a card or a mapping with 'law' and its constants"
        if isinstance(data, Law):
            return data
        if not isinstance(data, str | dict):
            raise fault(f"{given(data)}; {example}")
        data = self.written_out(data)
        place: tuple[str, ...] = ()
        if "card" in data:
            card = data["card"]
            place = ("card",)
            if not isinstance(card, str) or card not in CARDS:
                unknown = f"there is no material card {show(card)}; {nearest(card, CARDS)}"
                raise fault_at(place, f"{unknown} (a file of your own ends with .yaml)")
        elif "law" not in data:
            raise fault(f"neither 'card' nor 'law' is given; {example}")
        if "law" in data and (not isinstance(data["law"], str) or data["law"] not in self.laws()):
            law = data["law"]
            raise fault_at(
                ("law",), f"there is no law {show(law)} here; {nearest(law, self.laws())}"
            )
        if self.model_for(data) is None:
            laws, part = ", ".join(self.laws()), "layer" if self.layer else "region"
            raise fault_at(
                place, f"{show(data['card'])} is of another law than a {part} can have: {laws}"
            )
        try:
            return parse_material(data)
        except SpecError as error:
            raise fault("; ".join(error.lines)) from None

    def dump(self, model: BaseModel, info: Any) -> dict[str, Any]:
        """See ``Choice.dump``. The law and its constants stand first."""
        from softact.materials import Law

        data = super().dump(model, info)
        own = {key: data[key] for key in data if key not in Law.model_fields and key != "law"}
        return {"law": data["law"], **own, **data}

    def options(self) -> list[type[BaseModel]]:
        """See ``Choice.options``."""
        return list(self.laws().values())

    def also(self) -> tuple[str, ...]:
        """See ``Choice.also``."""
        return ("card", "law")

    def written_out(self, data: Any) -> Any:
        """See ``Choice.written_out``."""
        return {"card": data} if isinstance(data, str) else data

    def __get_pydantic_json_schema__(self, schema: Any, handler: Any) -> dict[str, Any]:
        from softact.materials import CARDS, card_data

        cards = [card for card in CARDS if card_data(card)["law"] in self.laws()]
        name = {"enum": cards, "type": "string", "description": "name of a material card"}
        file = {
            "type": "string",
            "pattern": r"\.ya?ml$",
            "description": "a card of your own, seen from the folder of the file that names it",
        }
        either = {"anyOf": [name, file]}
        overridden = {
            "type": "object",
            "properties": {"card": either},
            "required": ["card"],
            "description": "a card with constants of its law replaced",
        }
        options = super().__get_pydantic_json_schema__(schema, handler)
        return {"anyOf": [name, file, overridden, options]}
