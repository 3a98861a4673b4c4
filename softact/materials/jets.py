"""Truncated Taylor numbers: a law is written once as a formula and gives its derivatives too.

``Jet`` carries a value with its first and second derivatives in several variables; ``Series``
carries the first three derivatives in one variable. Both follow the usual operators and numpy's
``exp``, ``log`` and ``sqrt``, so that the same formula takes floats, arrays, jets and series.
Derivatives that are zero by structure (None) cost nothing, which is what makes a Yeoh law cheap.
Source of the rules: Griewank and Walther, Evaluating Derivatives, 2nd ed., chapters 3 and 13.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

#: What the formula of a law is written in: a float, an array, a ``Jet`` or a ``Series``.
Number: TypeAlias = Any
Derivative: TypeAlias = np.ndarray | float | None
#: The value of a function and its derivatives, from order 0 on.
Derivatives: TypeAlias = tuple[Number, ...]


def _add(a: Derivative, b: Derivative) -> Derivative:
    if a is None:
        return b
    return a if b is None else a + b


def _times(a: Derivative, b: Derivative) -> Derivative:
    return None if a is None or b is None else a * b


def _total(*terms: Derivative) -> Derivative:
    result = None
    for term in terms:
        result = _add(result, term)
    return result


def _power(x: Number, exponent: float, order: int) -> Derivatives:
    """Derivatives 0 to ``order`` of x**exponent; whole exponents by multiplication."""
    if float(exponent).is_integer() and 0 <= exponent <= 10:
        powers = [np.ones_like(x), x]
        for _ in range(2, int(exponent) + 1):
            powers.append(powers[-1] * x)
        result, factor = [], 1.0
        for k in range(order + 1):
            rest = int(exponent) - k
            result.append(factor * powers[rest] if rest > 0 else np.full_like(x, factor))
            factor *= rest
        return tuple(result)
    result, power = [], x**exponent
    for k in range(order + 1):
        result.append(power)
        power = power * ((exponent - k) / x)
    return tuple(result)


def _exp(x: Number, order: int) -> Derivatives:
    value = np.exp(x)
    return (value,) * (order + 1)


def _log(x: Number, order: int) -> Derivatives:
    inverse = 1.0 / x
    return (np.log(x), inverse, -inverse * inverse, 2.0 * inverse**3)[: order + 1]


def _sqrt(x: Number, order: int) -> Derivatives:
    return _power(x, 0.5, order)


def _reciprocal(x: Number, order: int) -> Derivatives:
    inverse = 1.0 / x
    square = inverse * inverse
    return (inverse, -square, 2.0 * square * inverse, -6.0 * square * square)[: order + 1]


class _Number:
    """What ``Jet`` and ``Series`` share: the operators, by ``_compose`` and ``_product``."""

    __slots__ = ()
    order = 2

    if TYPE_CHECKING:
        value: Any

        def _plus(self, other: Number) -> _Number: ...
        def _scaled(self, factor: Number) -> _Number: ...
        def _product(self, other: Number) -> _Number: ...
        def _compose(self, derivatives: Derivatives) -> _Number: ...
        def _masked(self, keep: np.ndarray, value: Number) -> _Number: ...
        def _with_value(self, value: Number) -> _Number: ...

    def __array_ufunc__(
        self, ufunc: np.ufunc, method: str, *inputs: Number, **kwargs: Any
    ) -> Number:
        action = _ACTIONS.get(ufunc.__name__)
        if method != "__call__" or kwargs or action is None:
            return NotImplemented
        return action(*inputs)

    def __add__(self, other: Number) -> _Number:
        return self._plus(other)

    __radd__ = __add__

    def __sub__(self, other: Number) -> _Number:
        return self._plus(-1.0 * other)

    def __rsub__(self, other: Number) -> _Number:
        return (-1.0 * self)._plus(other)

    def __neg__(self) -> _Number:
        return -1.0 * self

    def __mul__(self, other: Number) -> _Number:
        return self._product(other) if isinstance(other, _Number) else self._scaled(other)

    __rmul__ = __mul__

    def __truediv__(self, other: Number) -> _Number:
        if isinstance(other, _Number):
            return self * other._compose(_reciprocal(other.value, self.order))
        return self._scaled(1.0 / other)

    def __rtruediv__(self, other: Number) -> _Number:
        return self._compose(_reciprocal(self.value, self.order)) * other

    def __pow__(self, exponent: float) -> _Number:
        return self._compose(_power(self.value, exponent, self.order))

    def log(self) -> _Number:
        """Natural logarithm."""
        return self._compose(_log(self.value, self.order))


class Jet(_Number):
    """A value with gradient and Hessian in k variables.

    value: array (n,) or float. gradient: list of k derivatives. hessian: dict (i, j), i <= j, to
    derivative. None (or a missing pair) stands for a derivative that is zero by structure.
    """

    __slots__ = ("gradient", "hessian", "value")

    def __init__(
        self,
        value: Number,
        gradient: Sequence[Derivative],
        hessian: Mapping[tuple[int, int], np.ndarray | float],
    ):
        self.value, self.gradient, self.hessian = value, gradient, hessian

    def _plus(self, other: Number) -> Jet:
        if not isinstance(other, Jet):
            return Jet(self.value + other, self.gradient, self.hessian)
        gradient = [_add(a, b) for a, b in zip(self.gradient, other.gradient, strict=True)]
        hessian = dict(self.hessian)
        for pair, entry in other.hessian.items():
            hessian[pair] = hessian[pair] + entry if pair in hessian else entry
        return Jet(self.value + other.value, gradient, hessian)

    def _scaled(self, factor: Number) -> Jet:
        return Jet(
            self.value * factor,
            [_times(g, factor) for g in self.gradient],
            {pair: entry * factor for pair, entry in self.hessian.items()},
        )

    def _product(self, other: Number) -> Jet:
        a, b, hessian = self, other, {}
        for i, (ai, bi) in enumerate(zip(a.gradient, b.gradient, strict=True)):
            for j in range(i, len(a.gradient)):
                entry = _total(
                    _times(a.hessian.get((i, j)), b.value),
                    _times(b.hessian.get((i, j)), a.value),
                    _times(ai, b.gradient[j]),
                    _times(a.gradient[j], bi),
                )
                if entry is not None:
                    hessian[i, j] = entry
        gradient = [
            _add(_times(ai, b.value), _times(bi, a.value))
            for ai, bi in zip(a.gradient, b.gradient, strict=True)
        ]
        return Jet(a.value * b.value, gradient, hessian)

    def _compose(self, derivatives: Derivatives) -> Jet:
        value, first, second = derivatives
        hessian = {}
        for i, gi in enumerate(self.gradient):
            for j in range(i, len(self.gradient)):
                entry = _add(
                    _times(self.hessian.get((i, j)), first),
                    _times(_times(gi, self.gradient[j]), second),
                )
                if entry is not None:
                    hessian[i, j] = entry
        return Jet(value, [_times(g, first) for g in self.gradient], hessian)

    def _masked(self, keep: np.ndarray, value: Number) -> Jet:
        """Derivatives are kept where ``keep`` holds and zero elsewhere."""
        return Jet(
            value,
            [_times(g, keep) for g in self.gradient],
            {pair: entry * keep for pair, entry in self.hessian.items()},
        )

    def _with_value(self, value: Number) -> Jet:
        return Jet(value, self.gradient, self.hessian)


class Series(_Number):
    """A value with its first three derivatives in one variable: ``terms`` = (f, f', f'', f''')."""

    __slots__ = ("terms",)
    order = 3

    def __init__(self, *terms: Number):
        self.terms = terms

    @property
    def value(self) -> Number:
        """The value without its derivatives."""
        return self.terms[0]

    def _plus(self, other: Number) -> Series:
        if not isinstance(other, Series):
            return Series(self.terms[0] + other, *self.terms[1:])
        return Series(*(a + b for a, b in zip(self.terms, other.terms, strict=True)))

    def _scaled(self, factor: Number) -> Series:
        return Series(*(term * factor for term in self.terms))

    def _product(self, other: Number) -> Series:
        a0, a1, a2, a3 = self.terms
        b0, b1, b2, b3 = other.terms
        return Series(
            a0 * b0,
            a1 * b0 + a0 * b1,
            a2 * b0 + 2.0 * (a1 * b1) + a0 * b2,
            a3 * b0 + 3.0 * (a2 * b1 + a1 * b2) + a0 * b3,
        )

    def _compose(self, derivatives: Derivatives) -> Series:
        f0, f1, f2, f3 = derivatives
        _, x1, x2, x3 = self.terms
        square = x1 * x1
        return Series(
            f0,
            f1 * x1,
            f2 * square + f1 * x2,
            f3 * square * x1 + 3.0 * (f2 * x1 * x2) + f1 * x3,
        )

    def _masked(self, keep: np.ndarray, value: Number) -> Series:
        return Series(value, *(term * keep for term in self.terms[1:]))

    def _with_value(self, value: Number) -> Series:
        return Series(value, *self.terms[1:])


class Exponential(Series):
    """exp(rate · x) as a series in x: a stretch in its logarithm. Its powers stay exponentials."""

    __slots__ = ("logarithm", "rate")

    def __init__(self, logarithm: Number, rate: Number = 1.0):
        value = np.exp(rate * logarithm)
        super().__init__(value, rate * value, rate**2 * value, rate**3 * value)
        self.logarithm, self.rate = logarithm, rate

    def __pow__(self, exponent: float) -> Exponential:
        return Exponential(self.logarithm, self.rate * exponent)

    def log(self) -> Series:
        """rate · x: exact, where composing would lose digits near 1."""
        zero = np.zeros_like(self.logarithm)
        return Series(self.rate * self.logarithm, zero + self.rate, zero, zero)


def variables(*values: np.ndarray) -> list[Jet]:
    """Return one jet per value (each an array (n,)), each an independent variable."""
    count = len(values)
    return [
        Jet(value, [1.0 if j == i else None for j in range(count)], {})
        for i, value in enumerate(values)
    ]


def positive(x: Number) -> Number:
    """Return x where it is positive and 0 elsewhere (Macaulay bracket)."""
    if not isinstance(x, _Number):
        return np.maximum(x, 0.0)
    # Rounding must not decide whether the undeformed state (x = 0) is stiff: it counts as positive.
    keep = (x.value > -1e-12) * 1.0
    return x._masked(keep, x.value * keep)


def at_least(x: Number, lowest: float) -> Number:
    """Return x with its value lifted to ``lowest``; the derivatives are those of x.

    For terms such as sqrt(Ī1 − 3), whose derivatives are infinite in the undeformed state though
    the stress is not: the function is then evaluated a hair beside that point.
    """
    if not isinstance(x, _Number):
        return np.maximum(x, lowest)
    return x._with_value(np.maximum(x.value, lowest))


_ACTIONS: dict[str, Callable[..., Number]] = {
    "add": lambda a, b: b + a if isinstance(b, _Number) else a + b,
    "subtract": lambda a, b: (-b) + a if not isinstance(a, _Number) else a - b,
    "multiply": lambda a, b: b * a if isinstance(b, _Number) else a * b,
    "divide": lambda a, b: b.__rtruediv__(a) if not isinstance(a, _Number) else a / b,
    "power": lambda a, b: a**b,
    "exp": lambda x: x._compose(_exp(x.value, x.order)),
    "expm1": lambda x: x._compose((np.expm1(x.value), *_exp(x.value, x.order)[1:])),
    "log": lambda x: x.log(),
    "sqrt": lambda x: x._compose(_sqrt(x.value, x.order)),
}
