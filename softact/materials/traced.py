"""The formula of a law as C: it is carried out once on numbers that note what is done with them.

Jets of such numbers give the derivatives too. Constants stand in an array, so that the text is the
same for all laws of one form.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from softact.materials.invariants import InvariantLaw
from softact.materials.jets import Exponential, variables
from softact.materials.stretches import StretchLaw


class _Tape:
    """What has been done so far: lines of C, and the constants ``k`` in them."""

    def __init__(self) -> None:
        self.lines: list[str] = []
        self.constants: list[float] = []

    def note(self, expression: str) -> Traced:
        """A new number with the value of an expression."""
        name = f"v{len(self.lines)}"
        self.lines.append(f"    const double {name} = {expression};")
        return Traced(self, name)

    def of(self, value: Any) -> str:
        """How a number is written."""
        if isinstance(value, Traced):
            return value.name
        self.constants.append(float(value))
        return f"k[{len(self.constants) - 1}]"


# What numpy does with numbers that it does not know, and where one of its own stands first.
_FUNCTIONS: dict[np.ufunc, str] = {
    np.add: "{} + {}",
    np.subtract: "{} - {}",
    np.multiply: "{} * {}",
    np.true_divide: "{} / {}",
    np.power: "pow({}, {})",
    np.maximum: "fmax({}, {})",
    np.exp: "exp({})",
    np.expm1: "expm1({})",
    np.log: "log({})",
    np.sqrt: "sqrt({})",
}


class Traced:
    """A number of which only the name in C is known; takes what the formulas of laws do."""

    def __init__(self, tape: _Tape, name: str):
        self.tape, self.name = tape, name

    def _note(self, form: str, *inputs: Any) -> Traced:
        return self.tape.note(form.format(*map(self.tape.of, inputs)))

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **kwargs: Any) -> Any:
        form = _FUNCTIONS.get(ufunc)
        if method != "__call__" or kwargs or form is None:
            return NotImplemented
        return self._note(form, *inputs)

    def __array_function__(
        self, function: Callable[..., Any], types: Any, inputs: Sequence[Any], kwargs: Any
    ) -> Any:
        filled = {np.ones_like: 1.0, np.zeros_like: 0.0, np.full_like: inputs[-1]}
        return filled.get(function, NotImplemented)

    def __add__(self, other: Any) -> Traced:
        return self._note("{} + {}", self, other)

    def __radd__(self, other: Any) -> Traced:
        return self._note("{} + {}", other, self)

    def __sub__(self, other: Any) -> Traced:
        return self._note("{} - {}", self, other)

    def __rsub__(self, other: Any) -> Traced:
        return self._note("{} - {}", other, self)

    def __mul__(self, other: Any) -> Traced:
        return self._note("{} * {}", self, other)

    def __rmul__(self, other: Any) -> Traced:
        return self._note("{} * {}", other, self)

    def __truediv__(self, other: Any) -> Traced:
        return self._note("{} / {}", self, other)

    def __rtruediv__(self, other: Any) -> Traced:
        return self._note("{} / {}", other, self)

    def __pow__(self, exponent: float) -> Traced:
        return self._note("pow({}, {})", self, exponent)

    def __neg__(self) -> Traced:
        return self._note("-{}", self)

    def __gt__(self, other: Any) -> Traced:
        return self._note("({} > {} ? 1.0 : 0.0)", self, other)


def formula_in_c(law: InvariantLaw, families: int) -> tuple[str, np.ndarray]:
    """C text of ``formula(k, i, w, first, second)``, and its constants k.

    i: the invariants Ī1, Ī2 and those of ``families`` fibres, of which the formula has ``COUNT``,
    ``used``. w: W̄, MPa. first: (COUNT,) and second: (COUNT, COUNT) its derivatives.
    """
    tape = _Tape()
    inputs: list[Any] = [Traced(tape, f"i[{n}]") for n in range(2 + families)]
    energy = law.strain_energy(law, *variables(*inputs))
    used = [n for n, first in enumerate(energy.gradient) if first is not None]
    ends = [f"    *w = {tape.of(energy.value)};"]
    for a, n in enumerate(used):
        ends.append(f"    first[{a}] = {tape.of(energy.gradient[n])};")
        for b, m in enumerate(used):
            entry = energy.hessian.get((min(n, m), max(n, m)), 0.0)
            ends.append(f"    second[{a * len(used) + b}] = {tape.of(entry)};")
    text = [
        f"enum {{ FAMILIES = {families}, COUNT = {len(used)} }};",
        f"static const int used[COUNT] = {{{', '.join(map(str, used))}}};",
        "static inline void formula(const double *k, const double *i, double *w, double *first,",
        "                           double *second)",
        "{",
        *tape.lines,
        *ends,
        "}",
    ]
    return "\n".join(text) + "\n", np.array(tape.constants)


def stretch_formula_in_c(law: StretchLaw) -> tuple[str, np.ndarray]:
    """C text of ``formula(k, e, t, s, r)``, and its constants k.

    e: logarithm of an isochoric stretch. t, s, r: f', f'' and f''' in it, MPa.
    """
    tape = _Tape()
    logarithm: Any = Traced(tape, "e")
    _, *derivatives = law.stretch_energy(law, Exponential(logarithm)).terms
    ends = [
        f"    *{name} = {tape.of(value)};" for name, value in zip("tsr", derivatives, strict=True)
    ]
    text = [
        "static inline void formula(const double *k, double e, double *t, double *s, double *r)",
        "{",
        *tape.lines,
        *ends,
        "}",
    ]
    return "\n".join(text) + "\n", np.array(tape.constants)
