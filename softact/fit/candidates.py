"""The laws that can be fitted, with their free constants, bounds and where starts are drawn."""

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from types import SimpleNamespace
from typing import TypeAlias

import numpy as np

from softact.errors import SpecError
from softact.materials import LAWS, Law
from softact.materials.base import VOLUMETRIC
from softact.nearest import nearest

#: Constants by name in MPa, as the formula of a law reads them: free ones, or a law that has them.
Constants: TypeAlias = SimpleNamespace | Law

INFINITY = float("inf")
SMALLEST_EXPONENT = 1e-4  # of Ogden's law, which divides by it; its limit at 0 is met to 1e-8


@dataclass(frozen=True)
class Parameter:
    """A free constant.

    linear: the stress is proportional to it. seek: where starts are drawn. apart: how far it stays
    from 0. seek_at: gives ``seek`` from the larger of Ī1 and Ī2 that the data reach, in its place.
    """

    name: str
    lower: float = -INFINITY
    upper: float = INFINITY
    linear: bool = True
    seek: tuple[float, float] = (0.0, 1.0)
    logarithmic: bool = False
    apart: float = 0.0
    seek_at: Callable[[float], tuple[float, float]] | None = None

    def range_at(self, invariant: float) -> tuple[float, float]:
        """Where starts are drawn for data that reach an invariant, within the bounds."""
        low, high = self.seek_at(invariant) if self.seek_at else self.seek
        return self._bounded(low), self._bounded(high)

    def _bounded(self, value: float) -> float:
        return min(max(value, self.lower), self.upper)

    def settled(self, value: float) -> float:
        """The value, moved away from 0 where the law has none there."""
        if abs(value) >= self.apart:
            return float(value)
        return -self.apart if value < 0 else self.apart


@dataclass(frozen=True)
class Candidate:
    """A law with its free constants and the values of those that are not free."""

    name: str
    law: type[Law]
    parameters: tuple[Parameter, ...]
    fixed: dict[str, object] = field(default_factory=dict)

    def constants(self, vector: np.ndarray) -> Constants:
        """Return the constants by name (MPa), for the law's energy."""
        values = dict(self._held)
        for parameter, value in zip(self.parameters, vector, strict=True):
            values[parameter.name] = parameter.settled(value)
        return SimpleNamespace(**values)

    def settled(self, vector: np.ndarray) -> np.ndarray:
        """The constants as ``constants`` takes them."""
        return np.array([p.settled(v) for p, v in zip(self.parameters, vector, strict=True)])

    @cached_property
    def _held(self) -> dict[str, object]:
        own = {name: entry.default for name, entry in self.law.model_fields.items()
               if name not in Law.model_fields}  # fmt: skip
        return {**own, **self.fixed}

    def make(self, vector: np.ndarray, **fields: object) -> Law:
        """Return the law with these constants; ``fields`` are of the card, in internal units."""
        values = {p.name: float(v) for p, v in zip(self.parameters, vector, strict=True)}
        return self.law.of(**self.fixed, **values, **fields)

    @property
    def held_names(self) -> set[str]:
        """Own fields of the law that are no free constants, such as the number of families."""
        numbered = {name.rstrip("0123456789") for name in self.names}
        return {name for name in self._held if name.rstrip("0123456789") not in numbered}

    @property
    def names(self) -> list[str]:
        """Names of the free constants."""
        return [p.name for p in self.parameters]

    @property
    def lower(self) -> np.ndarray:
        """Lower bounds."""
        return np.array([p.lower for p in self.parameters])

    @property
    def upper(self) -> np.ndarray:
        """Upper bounds."""
        return np.array([p.upper for p in self.parameters])

    def fix(self, values: Mapping[str, object]) -> "Candidate":
        """Return the candidate with some constants held. Raises SpecError for unknown names."""
        for name in values:
            if name not in self.law.model_fields:
                own = (constant.name for constant in self.law.constants())
                hint = nearest(name, (*own, *VOLUMETRIC))
                raise SpecError(
                    f"--fix: the law {self.law.__name__} has no constant '{name}'; {hint}"
                )
        left = tuple(p for p in self.parameters if p.name not in values)
        return Candidate(self.name, self.law, left, {**self.fixed, **values})


@dataclass(frozen=True)
class Held(Candidate):
    """A material whose constants are all given, to be evaluated as a fit is."""

    material: Law = field(kw_only=True)

    def constants(self, vector: np.ndarray) -> Law:
        """Return the law itself: it holds its constants by name."""
        return self.material


def as_candidate(law: Law) -> Held:
    """Return a material as a candidate without free constants."""
    return Held(law.name or law.law, type(law), (), material=law)


def _polynomial(name: str, law: str, constants: str) -> Candidate:
    return Candidate(name, LAWS[law], tuple(Parameter(c) for c in constants.split()))


def _ogden(order: int) -> Candidate:
    # Positive moduli in Abaqus's convention make every term, and so the law, stable at any stretch.
    moduli = [Parameter(f"mu{i}", lower=0.0) for i in range(1, order + 1)]
    exponents = [
        Parameter(
            f"alpha{i}",
            lower=-25.0,
            upper=25.0,
            linear=False,
            seek=(-6.0, 8.0),
            apart=SMALLEST_EXPONENT,
        )
        for i in range(1, order + 1)
    ]
    pairs = [p for pair in zip(moduli, exponents, strict=True) for p in pair]
    return Candidate(f"ogden_{order}", LAWS["ogden"], tuple(pairs))


def _beyond_locking(invariant: float) -> tuple[float, float]:
    """Gent's Jm: the law has no stress where Ī1 − 3 is larger."""
    least = 1.02 * (invariant - 3.0)
    return max(0.5, least), max(200.0, 10.0 * least)


def _chain(invariant: float) -> tuple[float, float]:
    """The van der Waals law's λm: no stress where Ī1, or Ī2, is larger than its square."""
    least = 1.02 * math.sqrt(invariant)
    return max(2.0, least), max(20.0, 10.0 * least)


def _bounded_growth(invariant: float) -> tuple[float, float]:
    """Fung's b: the exponential grows by 5 % to e^10 over the data."""
    reached = max(invariant - 3.0, 1e-6)
    return 0.05 / reached, 10.0 / reached


def _candidates() -> dict[str, Candidate]:
    modulus = Parameter("mu", lower=0.0)
    locking = Parameter("lambda_m", 1.05, 100.0, linear=False, seek=(1.2, 15.0), logarithmic=True)
    entries = [
        _polynomial("neo_hookean", "neo_hookean", "c10"),
        _polynomial("mooney_rivlin_2", "mooney_rivlin", "c10 c01"),
        _polynomial("mooney_rivlin_3", "mooney_rivlin", "c10 c01 c11"),
        _polynomial("mooney_rivlin_5", "mooney_rivlin", "c10 c01 c20 c11 c02"),
        _polynomial("mooney_rivlin_9", "mooney_rivlin", "c10 c01 c20 c11 c02 c30 c21 c12 c03"),
        _polynomial("yeoh", "yeoh", "c10 c20 c30"),
        *(
            _polynomial(
                f"reduced_polynomial_{n}",
                "reduced_polynomial",
                " ".join(f"c{i}0" for i in range(1, n + 1)),
            )
            for n in range(1, 7)
        ),
        *(_ogden(n) for n in range(1, 7)),
        Candidate("arruda_boyce", LAWS["arruda_boyce"], (modulus, locking)),
        Candidate(
            "van_der_waals",
            LAWS["van_der_waals"],
            (
                modulus,
                Parameter("lambda_m", 1.75, 100.0, linear=False, logarithmic=True, seek_at=_chain),
                Parameter("a", -2.0, 5.0, linear=False, seek=(0.0, 1.0)),
                Parameter("beta", 0.0, 1.0, linear=False, seek=(0.0, 1.0)),
            ),
        ),
        Candidate(
            "gent",
            LAWS["gent"],
            (
                modulus,
                Parameter("jm", 0.05, 1e6, linear=False, logarithmic=True, seek_at=_beyond_locking),
            ),
        ),
        Candidate(
            "fung",
            LAWS["fung"],
            (
                modulus,
                Parameter("b", 1e-6, 1e4, linear=False, logarithmic=True, seek_at=_bounded_growth),
            ),
        ),
        Candidate(
            "holzapfel",
            LAWS["holzapfel"],
            (
                Parameter("c10", lower=0.0),
                Parameter("k1", lower=0.0),
                Parameter("k2", 0.0, 200.0, linear=False, seek=(1e-3, 10.0), logarithmic=True),
                Parameter("kappa", 0.0, 1 / 3, linear=False, seek=(0.0, 1 / 3)),
                Parameter("angle", 0.0, 90.0, linear=False, seek=(0.0, 90.0)),
            ),
            {"families": 2},
        ),
    ]
    return {entry.name: entry for entry in entries}


CANDIDATES = _candidates()
USUAL = {
    "mooney_rivlin": "mooney_rivlin_2",
    "reduced_polynomial": "reduced_polynomial_3",
    "ogden": "ogden_3",
    "hgo": "holzapfel",
}
# Orders above these are offered by name but not tried by --law all: they follow the noise.
ALL_ISOTROPIC = (
    "neo_hookean", "mooney_rivlin_2", "mooney_rivlin_3", "mooney_rivlin_5", "mooney_rivlin_9",
    "yeoh", "reduced_polynomial_2", "reduced_polynomial_4", "reduced_polynomial_5",
    "reduced_polynomial_6", "ogden_1", "ogden_2", "ogden_3", "ogden_4", "arruda_boyce",
    "van_der_waals", "gent", "fung",
)  # fmt: skip


def chosen(name: str, anisotropic: bool) -> list[Candidate]:
    """Return the candidates that ``--law`` means; 'all' for every law that suits the data.

    Raises SpecError for an unknown law.
    """
    key = re.sub(r"(?<=[a-z])(?=\d+$)", "_", name.strip().lower().replace("-", "_"))
    if key == "all":
        names = ("holzapfel", "neo_hookean", "yeoh", "ogden_2") if anisotropic else ALL_ISOTROPIC
        return [CANDIDATES[n] for n in names]
    key = USUAL.get(key, key)
    if key not in CANDIDATES:
        hint = nearest(key, ["all", *CANDIDATES])
        raise SpecError(f"--law: there is no law '{name}' to fit; {hint}")
    return [CANDIDATES[key]]
