"""What the columns of a test's table mean: quantity and unit, read from headings."""

import re
import unicodedata
from dataclasses import dataclass, replace

from softact.measured.spelling import (
    RATIOS,
    clean,
    mega_for_milli,
    registry_unit,
    weight_for_mass,
)
from softact.units import FORCE, LENGTH, PRESSURE, Dimension, show

RATIO = "ratio"  # of no unit, or in percent


@dataclass(frozen=True)
class Quantity:
    """A kind of column. role: 'x' for deformation, 'y' for load, '' for anything not used."""

    name: str
    role: str
    dimension: Dimension | str | None
    words: str


# In English, German and French, as the programs of the machines write them. Words are small
# letters without accents; 'spannung' stands for any word that holds it.
_STRESS = r"(\bstress\b|spannung|\bcontrainte|\bsigma\b|σ)"
_STRAIN = r"(\bstrain\b|dehnung|stauchung|\bepsilon\b|\beps\b|ε|\bextensometer\b)"
_TRUE = r"(\btrue\b|\blog\b|logarithmi|\bhencky\b|\bwahre|\bvraie?\b|\bnatural\b)"
_NOMINAL = r"(\bengineering\b|\beng\b|\bnominal|\bnom\b|\bpiola\b|\bpk1\b|\bnenn|\btechnisch)"
_BY_STANDARD = r"(\btensile\b|\bcompressive\b|\bcompression\b|zug|druck|\btraction\b)"
_COUNTER = r"(no|nr|number|point|index|count|id|sample|scan|row|record|line|zeile|nummer)"
# The first whose words are found wins: the more precise ones come first.
QUANTITIES = (
    Quantity("ignored", "", None, r"^-?$"),
    Quantity("ignored", "", None, rf"^({_COUNTER}|\d| )+$"),
    Quantity("ignored", "", None,
             r"(\btime\b|zeit\b|\btemps\b|\brate\b|\bspeed\b|\bvelocity\b|\bcycles?\b|\bzyklus\b"
             r"|\btemp\b|temperatur|\benergy\b|\bwork\b|\bpower\b|\bmodulus\b|\bpoisson"
             r"|\btransverse\b|\blateral\b|\bquer|\bfit\b|\bfitted\b|\bmodel\b|\bpredicted\b"
             r"|\bsimulat|\bfem\b|\bfea\b|\bdate\b|\bdatum\b|\bwidth\b|\bthickness\b|\barea\b"
             r"|\bbreite\b|dicke\b)"),
    Quantity("specimen", "", None, r"\bspecimen\b"),
    Quantity("true_strain", "x", RATIO, rf"(?=.*{_TRUE}).*{_STRAIN}"),
    Quantity("cauchy_stress", "y", PRESSURE, rf"((?=.*{_TRUE}).*{_STRESS}|\bcauchy\b|\bsigma c\b)"),
    Quantity("nominal_stress", "y", PRESSURE, rf"((?=.*{_NOMINAL}).*{_STRESS}|\bpk1\b)"),
    Quantity("standard_stress", "y", PRESSURE, rf"(?=.*{_BY_STANDARD}).*{_STRESS}"),
    Quantity("stress", "y", PRESSURE, _STRESS),
    Quantity("stretch", "x", RATIO,
             r"(\bstretch\b|streckung|\blambda\b|λ|\b(draw|extension) ratio)"),
    Quantity("strain", "x", RATIO, _STRAIN),
    Quantity("displacement", "x", LENGTH,
             r"(\bdisp(lacement)?\b|\bextension\b|\belongation\b|\bstroke\b|\bcrosshead\b"
             r"|\btravel\b|weg\b|verschiebung|verlangerung|\bdeplacement|\ballongement"
             r"|\bdeflection\b|\bdeformation\b|verformung)"),
    Quantity("position", "x", LENGTH, r"(\bposition\b|traversenposition)"),
    Quantity("length", "x", LENGTH, r"(\blength\b|lange\b|\blongueur\b)"),
    Quantity("force", "y", FORCE, r"(\bforce\b|\bload\b|\bloadcell\b|kraft|\blast\b|\bcharge\b)"),
)  # fmt: skip
_NAMED = {quantity.name: quantity for quantity in QUANTITIES}
DIRECTIONS = ("course", "wale")
_COMPRESSIVE = re.compile(r"\bcompress|druck|stauch")


@dataclass(frozen=True)
class Column:
    """One column: its quantity, the factor to internal units, and the sheet's direction if named.

    factor: None where the heading names no unit and the quantity needs one. unit: as it was read,
    empty where there is none. fault: why the column cannot be used, None where it can. remark:
    what was read otherwise than it stands. compressive: the heading speaks of compression.
    """

    heading: str
    quantity: Quantity
    factor: float | None
    direction: str | None
    unit: str = ""
    fault: str | None = None
    remark: str | None = None
    compressive: bool = False

    @property
    def written(self) -> str:
        """The column as a heading that is read without a question: 'force kN'."""
        name = self.quantity.name
        if not self.quantity.role:
            return "specimen" if name == "specimen" else "-"
        if name in ("standard_stress", "stress"):
            name = "nominal_stress"
        direction = f"{self.direction} " if self.direction else ""
        return f"{direction}{name} {self.unit}".strip()


def counts_only(text: str) -> bool:
    """Whether a heading names the time or a number of the row, which no curve needs."""
    words = plain_words(re.sub(r"[(\[].*", "", text))
    return bool(re.search(rf"^({_COUNTER}|\d| )+$|\btime\b|zeit\b|\btemps\b|\bcycles?\b", words))


def read_heading(text: str) -> Column:
    """Return what a heading such as ``Engineering Stress (MPa)`` or ``strain_percent`` means."""
    quoted = unicodedata.normalize("NFKC", text).strip(" \"'")
    outside, inside = _brackets(quoted)
    column = _meaning(text, outside, inside)
    if column.quantity.role:
        return column
    # 'Strain 1 (Displacement) mm' is no displacement, but '(Load) N' is a load.
    other = _meaning(text, " ".join([*inside, outside]), [])
    return other if other.quantity.role and not plain_words(outside) else column


def _brackets(text: str) -> tuple[str, list[str]]:
    pattern = r"[(\[{<]([^()\[\]{}<>]*)[)\]}>]"
    return re.sub(pattern, " ", text), [part.strip() for part in re.findall(pattern, text)]


def _meaning(heading: str, outside: str, inside: list[str]) -> Column:
    for quantity in QUANTITIES:
        name, unit = _split(outside, inside, quantity.dimension)
        words = plain_words(name)
        if re.search(quantity.words, words):
            break
    else:
        # Whatever is in newtons is a force: 'F (N)'.
        name, unit = _split(outside, inside, FORCE)
        force = plain_words(name) and registry_unit(unit, FORCE)
        quantity, words = _NAMED["force"] if force else QUANTITIES[0], plain_words(outside)
    direction = next((d for d in DIRECTIONS if d in words.split()), None)
    remark = f"'{heading}' read as Cauchy stress" if re.search(r"\bsigma c\b", words) else None
    column = Column(heading, quantity, None, direction, remark=remark,
                    compressive=bool(_COMPRESSIVE.search(words)))  # fmt: skip
    return _with_unit(column, unit, inside) if quantity.role else replace(column, factor=1.0)


def plain_words(text: str) -> str:
    """The words of a heading in small letters without accents: 'TensileStrain_1' too."""
    text = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", text)
    plain = unicodedata.normalize("NFKD", text.lower().replace("ß", "ss"))
    plain = "".join(c for c in plain if not unicodedata.combining(c))
    return " ".join(re.findall(r"[^\W\d_]+|\d+", plain))


def _split(outside: str, inside: list[str], dimension: Dimension | str | None) -> tuple[str, str]:
    """The name of a heading and its unit: from brackets, or from its end ('Kraft in N')."""
    for part in reversed(inside):
        if _known(part, dimension):
            return outside, part
    text = re.sub(r"[,;:]", " ", outside)
    parts = [part for part in re.split(r"[\s_]+", text) if part]
    for count in (3, 2, 1):
        end = " ".join(parts[-count:])
        unit = end.lstrip("/ ")
        if count < len(parts) and (count == 1 or "/" in end) and _known(unit, dimension):
            rest = parts[:-count]
            return " ".join(rest[:-1] if rest[-1] in ("in", "/", "-") else rest), unit
    name, slash, unit = (parts[-1] if parts else "").partition("/")
    if slash and name and _known(unit, dimension):
        return " ".join([*parts[:-1], name]), unit
    return outside, ""


def _known(text: str, dimension: Dimension | str | None) -> bool:
    """Whether ``text`` is a unit of the dimension, or of another that could be taken for it."""
    if not text or dimension is None:
        return False
    ratio = clean(text).lower()
    if ratio in RATIOS and ratio not in ("", "1", "ratio", "none"):
        return True
    # A single letter at the end of a name is a unit only where it fits: 'strain m' is none.
    kinds = (LENGTH, FORCE, PRESSURE) if len(ratio) > 1 else (dimension,)
    return any(isinstance(k, Dimension) and registry_unit(text, k) for k in kinds)


def _with_unit(column: Column, text: str, inside: list[str]) -> Column:
    """The column with its factor; a strain in mm is a displacement, an extension in % a strain."""
    quantity, heading = column.quantity, column.heading
    ratio = RATIOS.get(clean(text).lower())
    if quantity.name == "strain" and (unit := registry_unit(text, LENGTH)):
        column = replace(column, remark=f"'{heading}' is in {unit}: read as a displacement")
        quantity = _NAMED["displacement"]
    elif quantity.name == "displacement" and text and ratio is not None and clean(text) != "-":
        quantity = _NAMED["strain"]
    column = replace(column, quantity=quantity)
    name = quantity.name.replace("_", " ").replace("standard ", "")
    if quantity.dimension is RATIO:
        if ratio is not None:
            return replace(column, factor=ratio, unit="%" if ratio == 0.01 else clean(text))
        return replace(column, fault=f"'{heading}': '{text}' is no unit of a {name}")
    dimension = quantity.dimension
    assert isinstance(dimension, Dimension)  # all others have been answered
    unit = registry_unit(text, dimension)
    if unit is None:
        unknown = text or next((part for part in reversed(inside) if part), "")
        return replace(column, fault=_unit_fault(heading, unknown, dimension))
    remark = column.remark
    if mega_for_milli(text):
        remark = f"'{heading}': mPa read as MPa"
    elif dimension is not LENGTH and weight_for_mass(text):
        remark = f"'{heading}': {clean(text)} read as {unit}, a weight"
    return replace(column, factor=dimension.parse(f"1 {unit}"), unit=unit, remark=remark)


def _unit_fault(heading: str, unit: str, dimension: Dimension) -> str:
    if not unit:
        return f"'{heading}' has no unit"
    try:
        dimension.parse(f"1 {unit}")
    except ValueError as error:
        said = str(error).replace(f"'1 {unit}'", show(unit))
        return f"'{heading}': {said}"
    except TypeError:
        return f"'{heading}': {show(unit)} is no unit of a {dimension.name}"
    return f"'{heading}' has no unit"
