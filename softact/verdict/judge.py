"""What a reader may think of a run: solved and trusted, solved but, not solved; with reasons.

Decided from what the run has written, and from nothing else: run.json (how it ended and what the
solver remarked), curve.csv (motions, kinetic energy, changes of the material's volume, folded
elements), fields.h5 (bodies that pass through themselves, walls that give way) and mesh_error.json,
where a convergence study was carried in.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from softact.errors import SoftactError, SpecError
from softact.files.text import write_atomic
from softact.materials import compressible
from softact.materials.cards import parse_material
from softact.measures.strain import (
    BEYOND_COLUMN,
    BOUND,
    INCOMPRESSIBLE,
    JACOBIAN_COLUMN,
    PERCENTILE_COLUMN,
)
from softact.results.folder import (
    COMPLETE,
    MESH_ERROR,
    NO_EQUILIBRIUM,
    Results,
    load,
    load_text,
    place_text,
    read,
)
from softact.results.run_json import RUN, run_text
from softact.verdict import gives_way
from softact.verdict.overlap import first_overlap
from softact.verdict.reached import moving_rows
from softact.verdict.waves import first_waves

GREEN, AMBER, RED = "green", "amber", "red"
WORDS = {GREEN: "solved and trusted", AMBER: "solved, but", RED: "not solved"}

#: Percent of the volume of nearly incompressible material that may change by more than ``BOUND``.
VOLUME_SHARE = 1.0
#: Percent of that volume from which on it is the material's doing, not that of a corner.
WIDELY = 20.0
#: Ratio of kinetic to internal energy above which a motion is more than quasi-static.
QUASI_STATIC = 0.05
#: Part of the largest load up to which the states may be those of a slow motion: sheets without
#: stiffness cannot begin otherwise.
BEGINNING = 0.1
#: What a convergence study says of a mesh, from the best to the worst.
WITHIN, NOT_KNOWN, NOT_CONVERGED = "within", "not known", "not converged"


#: What each kind of reason is about, in the order in which they are told.
TITLES = {
    "end": "End:",
    "limit": "What gives way:",
    "waves": "Period:",
    "motion": "Motion:",
    "kinetic": "Kinetic energy:",
    "overlap": "Overlap:",
    "volume": "Volume:",
    "folded": "Elements:",
    "mesh": "Mesh:",
    "remark": "Remark:",
    "unread": "Not looked at:",
}


#: Kinds of which a reader is shown the place.
SEEN = ("overlap",)


@dataclass(frozen=True)
class Reason:
    """Why a run is not simply trusted. kind: one of ``TITLES``. place: (x, y, z) mm where it is
    seen in the state ``row``, where there is one."""

    kind: str
    text: str
    place: tuple[float, float, float] | None = field(default=None, compare=False)
    row: int | None = field(default=None, compare=False)


@dataclass(frozen=True)
class Verdict:
    """colour: "green", "amber" or "red"; reasons: none where it is green."""

    colour: str
    reasons: tuple[Reason, ...] = ()

    @property
    def words(self) -> str:
        """What the colour means."""
        return WORDS[self.colour]

    @property
    def lines(self) -> list[str]:
        """For people: the words, and a line for each reason."""
        head = self.words + (":" if self.reasons else "")
        return [head, *(f"  - {reason.text}" for reason in self.reasons)]

    @property
    def cell(self) -> str:
        """For a table: the colour and the kinds of the reasons, such as "amber: overlap, mesh"."""
        kinds = ", ".join(dict.fromkeys(reason.kind for reason in self.reasons))
        return f"{self.colour}: {kinds}" if kinds else self.colour

    @property
    def has_places(self) -> bool:
        """Whether it knows where that is seen which it speaks of."""
        return all(reason.place is not None for reason in self.reasons if reason.kind in SEEN)

    def data(self, places: bool = False) -> dict:
        """What run.json holds; places: with these, for whoever draws them."""
        reasons = [
            {"kind": reason.kind, "text": reason.text}
            | ({"place": reason.place, "row": reason.row} if places else {})
            for reason in self.reasons
        ]
        return {"colour": self.colour, "words": self.words, "reasons": reasons}


def from_data(data: Any) -> Verdict | None:
    """The verdict that ``Verdict.data`` gave, such as run.json's; None where that is none."""
    try:
        reasons = tuple(map(_reason, data["reasons"]))
        return Verdict(data["colour"], reasons) if data["colour"] in WORDS else None
    except (KeyError, TypeError, ValueError):
        return None


def _reason(data: Any) -> Reason:
    kind, text, place = str(data["kind"]), str(data["text"]), data.get("place")
    if place is not None:
        x, y, z = map(float, place)
        place = x, y, z
    return Reason(kind, text, place, data.get("row"))


def judge(results: Results) -> Verdict:
    """The verdict on a run, finished or not."""
    reasons = sorted([*_of_run(results), *_of_fields(results)], key=_order)
    if results.status != COMPLETE:
        return Verdict(RED, tuple(reasons))
    return Verdict(AMBER if reasons else GREEN, tuple(reasons))


def _order(reason: Reason) -> int:
    return list(TITLES).index(reason.kind)


def store(directory: Path) -> Verdict:
    """Judge a run anew and write the verdict into its run.json, where something was added to its
    folder that counts."""
    results = read(directory)
    verdict = judge(results)
    write_atomic(directory / RUN, run_text({**results.run, "verdict": verdict.data()}))
    return verdict


def _of_fields(results: Results) -> list[Reason]:
    """What the fields say, and what of the folder is damaged."""
    found, faults = [], list(results.faults)
    looked_at = bool(results.increments) or not faults
    if results.increments:
        try:
            text = gives_way.limit_text(results)
            found = [*([Reason("limit", text)] if text else []), *_overlap(results)]
        except SpecError as error:  # fields that are damaged
            looked_at, faults = False, list(dict.fromkeys([*faults, *error.lines]))
    if faults:
        text = "" if looked_at else "whether the actuator passes through itself was not looked at: "
        found.append(Reason("unread", text + "; ".join(faults)))
    return found


def _of_run(results: Results) -> Iterator[Reason]:
    """What run.json, the curve and a study of the mesh say."""
    messages = [str(message) for message in results.run.get("messages") or []]
    yield from _waves(results)
    if results.status == NO_EQUILIBRIUM:
        yield Reason("end", messages.pop(0) if messages else "no further equilibrium was found")
    elif results.status != COMPLETE:
        yield Reason("end", "the run has not ended, or was stopped")
    yield from (Reason("remark", message) for message in messages)
    yield from _motion(results)
    yield from _volume(results)
    yield from _folded(results)
    yield from _mesh(results)


def _motion(results: Results) -> Iterator[Reason]:
    """States that are no equilibria, and motions that were fast."""
    loads, moving = np.abs(load(results)), moving_rows(results)
    if moving.any() and moving[-1]:
        yield Reason("motion", "the last state is one of a motion and no equilibrium")
    elif moving.any():
        last = int(np.flatnonzero(moving)[-1])
        if loads[moving].max() > BEGINNING * loads.max():
            yield Reason(
                "motion",
                f"the states up to {load_text(results, last)} are of a slow motion and no "
                "equilibria; those after them are",
            )
    ratios = results.curve.get("kinetic_ratio")
    if ratios is None or ratios.dtype != float:
        return
    jumped = np.where(moving, 0.0, np.nan_to_num(ratios))
    if jumped.max(initial=0.0) > QUASI_STATIC:
        row = int(np.argmax(jumped))
        yield Reason(
            "kinetic",
            f"on the way to {load_text(results, row)} the kinetic energy was up to "
            f"{100 * jumped[row]:.0f} % of the internal energy: where a real actuator comes to "
            "rest in may depend on its mass and damping",
        )


def _volume(results: Results) -> Iterator[Reason]:
    """A nearly incompressible material that does not keep its volume."""
    curve = results.curve
    shares = curve.get(BEYOND_COLUMN)
    if shares is None or shares.dtype != float or not np.nan_to_num(shares).max(initial=0) > 0:
        return
    row = int(np.argmax(np.nan_to_num(shares)))
    if shares[row] <= VOLUME_SHARE:
        return
    text = (
        f"a nearly incompressible material does not keep its volume: at {load_text(results, row)}, "
        f"{shares[row]:.2g} % of it changes by more than {100 * BOUND:g} %"
    )
    if PERCENTILE_COLUMN in curve:
        text += f" (1 % of it by more than {100 * curve[PERCENTILE_COLUMN][row]:.0f} %"
        worst, place = curve.get("volume_change_max"), _place(curve, "volume_change_max", row)
        if worst is not None and place:
            text += f"; at single points up to {100 * worst[row]:.0f} %, at {place}"
        text += ")"
    remedy = "refine the mesh there, or round a sharp corner"
    if shares[row] > WIDELY:
        remedy = (
            "stresses come near the bulk modulus K, so that the law itself allows it and the "
            "forces fall short of those of a rubber that keeps its volume; "
            f"{_stiffer_volume(results)}"
        )
    yield Reason("volume", f"{text}: {remedy}")


def _stiffer_volume(results: Results) -> str:
    """What keeps the volume, by region, as it is written in a spec."""
    said = []
    try:
        for region, given in results.spec["materials"].items():
            law = parse_material(given)
            if law.initial_bulk_modulus >= INCOMPRESSIBLE * law.shear_modulus:
                ratio = law.initial_bulk_modulus / law.shear_modulus
                said.append(
                    f"{compressible.nearly_incompressible(law)} in materials.{region} (K is "
                    f"{ratio:.3g} times the shear modulus now)"
                )
    except (SoftactError, ValueError, KeyError, TypeError, AttributeError):
        said = []  # the spec is damaged, which is told elsewhere
    return f"{' and '.join(said) or 'a larger bulk_modulus'} keeps it"


def _folded(results: Results) -> Iterator[Reason]:
    """Elements that are inside out at a corner: they carry their forces, but not rightly."""
    smallest = results.curve.get(JACOBIAN_COLUMN)
    if smallest is None or smallest.dtype != float or not (smallest <= 0).any():
        return
    row, first = int(np.nanargmin(smallest)), int(np.flatnonzero(smallest <= 0)[0])
    begun = f", and at or below 0 from {load_text(results, first)} on" if first != row else ""
    place = _place(results.curve, JACOBIAN_COLUMN, row)
    yield Reason(
        "folded",
        f"elements are folded at a corner{f' near {place}' if place else ''} (J = det F is "
        f"{smallest[row]:.2g} there at {load_text(results, row)}{begun}): refine the mesh there",
    )


def _place(curve: Mapping[str, np.ndarray], stem: str, row: int) -> str:
    columns = [curve[name] for axis in "xyz" if (name := f"{stem}_{axis}_mm") in curve]
    if len(columns) < 3 or any(column.dtype != float for column in columns):
        return ""
    where = place_text(column[row] for column in columns)
    return f"x, y, z = {where} mm of the undeformed actuator"


def _mesh(results: Results) -> Iterator[Reason]:
    """A mesh of which a study does not say that it is within what was wanted."""
    try:
        story = json.loads((results.directory / MESH_ERROR).read_text(encoding="utf-8"))
        level = story["levels"][story["level"]]
        if level["spec_hash"] != results.run.get("spec_hash") or story["verdict"] == WITHIN:
            return
        within = f"{100 * float(story['tolerance']):g} %"
        verdicts = {str(name): entry["verdict"] for name, entry in story["measures"].items()}
        bars = {str(name): float(bar) for name, bar in story["error_bars"].items()}
        values = {name: abs(float(results.curve[name][-1])) for name in bars}
        better = (story.get("recommended_mm") or {}).items()
    except (OSError, ValueError, KeyError, IndexError, TypeError, AttributeError):
        return  # not there; the report says of a file that cannot be read
    parts = {name: f" (known to {_percent(bars[name], values[name])})" for name in bars}
    coarse = ", ".join(f"{n}{parts.get(n, '')}" for n, v in verdicts.items() if v == NOT_CONVERGED)
    unknown = ", ".join(name for name, v in verdicts.items() if v not in (NOT_CONVERGED, WITHIN))
    said = [f"the mesh has not converged within {within}: {coarse}"] if coarse else []
    said += [f"how far the mesh is from its limit is not known: {unknown}"] if unknown else []
    sizes = ", ".join(f"{name} {size:.3g} mm" for name, size in better)
    said.append(f"{sizes} is enough" if sizes else "no mesh of the study is known to be enough")
    yield Reason("mesh", "; ".join(said))


def _percent(bar: float, value: float) -> str:
    return f"{100 * bar / value:.0f} %" if value > 0 else "more than its own size"


def _waves(results: Results) -> Iterator[Reason]:
    """A module whose chain buckles with a longer period."""
    if found := first_waves(results):
        word, row = found
        yield Reason(
            "waves",
            f"from {load_text(results, row)} on the chain buckles with a period of {word} modules: "
            "its modules are no longer alike, and one of them does not stand for it; solve the "
            "whole actuator",
            row=row,
        )


def _overlap(results: Results) -> Iterator[Reason]:
    """An actuator that passes through itself."""
    for row in _last_rows(results):
        found = first_overlap(results, row)
        if found is None:
            continue
        first, worst = found
        where = place_text(worst.place)
        depth = f"{'at least ' if worst.at_least else ''}{worst.depth:.2g} mm deep"
        much = f"{100 * worst.share:.1f} % of its surface lies inside of it, up to {depth}"
        if worst.share < 5e-4:
            much = f"single points of it, {depth}"
        begun = f", from {load_text(results, first)} on" if first != row else ""
        parts = ", ".join(f"'{name}'" for name in worst.surfaces)
        parts = f"parts of {parts}; " if parts else ""
        yield Reason(
            "overlap",
            f"the actuator passes through itself at {load_text(results, row)}{begun}: {much} "
            f"({parts}deepest at x, y, z = {where} mm of the undeformed actuator); "
            f"{_remedy(results, worst.surfaces)}",
            tuple(worst.seen.tolist()),
            row,
        )
        return


def _remedy(results: Results, found: Sequence[str]) -> str:
    # A wall that another one has passed whole lies inside too: it was the outside that met first.
    names = [name for name in found if name in results.layout.outside]
    contact = results.spec.get("contact")
    if _seen_by(contact, names):
        return (
            "contact is there, but acts at points within faces, so that edges get past them: "
            "a smaller mesh_size sees them sooner"
        )
    if names and contact in (None, "none", []):
        wanted = "contact: auto"
    else:
        surfaces = ", ".join(names or found)
        wanted = f"{{self: [{surfaces}]}} under contact" if surfaces else "contact"
    return f"{wanted} in the spec keeps these parts from each other"


def _seen_by(contact: Any, names: Sequence[str]) -> bool:
    """Whether a spec's contact is of surfaces, of the outside, with themselves."""
    if not names or contact in (None, "none", []):
        return False
    if not isinstance(contact, list):
        return True  # auto: of the whole outside
    with_itself = [pair.get("self") for pair in contact if isinstance(pair, dict)]
    lists = [[one] if isinstance(one, str) else one for one in with_itself if one]
    return any(set(names) <= set(surfaces) for surfaces in lists)


def _last_rows(results: Results) -> list[int]:
    """The last states of the steps, from the last one back: those that a reader sees first."""
    count = len(results.increments)
    steps = results.curve.get("step")
    if steps is None:
        return [count - 1]
    ends = [n for n in range(count) if n + 1 == count or steps[n] != steps[n + 1]]
    return ends[::-1]
