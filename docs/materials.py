"""Writes docs/materials.md from the laws and cards: `.venv/bin/python docs/materials.py`.

A test sees to it that the page in the repository is the current one.
"""

from pathlib import Path

from softact.materials import CARDS, LAWS, Law, card_data
from softact.materials.base import DEFAULT_POISSONS_RATIO
from softact.units import dimension_of

PAGE = Path(__file__).with_name("materials.md")

INTRODUCTION = f"""# Materials

This page is written by `.venv/bin/python docs/materials.py` from the code; do not edit it.

A law is an isochoric energy W̄ per undeformed volume and a volumetric energy. Ī1, Ī2 are the first
two invariants of C̄ = J^(−2/3) C, λ̄i = J^(−1/3) λi the isochoric principal stretches, and
Ī4α = aα·C̄aα the squared isochoric stretch of the fibres aα. The solver and `softact fit` call the
same formula; its derivatives are exact (Taylor arithmetic), also at equal principal stretches.

## The volumetric part

U = K/2 (J − 1)² + Σ (J − 1)^(2i)/Di for i = 2 to 6. K comes from one of `bulk_modulus`,
`d1` (K = 2/D1) or `poissons_ratio` ν (K = 2 μ (1 + ν) / (3 (1 − 2ν)), μ: initial shear modulus).
Where none is given, ν = {DEFAULT_POISSONS_RATIO} is taken, K = 500 μ, and stands in the resolved
spec. Laws whose source writes K/2 ((J² − 1)/2 − ln J) use that form.

## Fibres

`holzapfel` is the law of a region with fibres. They lie in the region's wall, whose normal the
geometry tells (along the radius in a tube or a sphere, z in flat parts); `normal: [0, 1, 0]` in the
material names another plane. `angle` counts in that plane from the actuator's axis, x. One family
at an angle needs the whole actuator: a half that is mirrored would have two.

    materials:
      body: {{law: holzapfel, c10: 0.1 MPa, k1: 20 MPa, angle: 60 deg, families: 2}}

## Cards

A material is the name of a card below, `{{card: NAME, c10: 0.2 MPa}}` with some of its constants
replaced, `{{law: LAW, ...}}`, or a card of your own: `card: ./my_silicone.yaml`, a file seen from
the folder of the file that names it, which holds what a card holds. Regions, layers and plies take
all of them. `softact fit` writes such files:

    law: yeoh
    c10: 0.11 MPa
    c20: 0.02 MPa
    density: 1130 kg/m^3
    stretch_range: [1, 2.6]     # optional: a run warns where it is left
    strength: 6.5 MPa           # optional
    strength_is: nominal        # per undeformed area; or true: per area at break
    elongation: 7               # optional, at break: 700 %

`softact calibrate SPEC --data angle.csv --vary materials.body.c10` adjusts constants until a run of
the actuator meets a curve that was measured on it. Each run carries its
[derivatives](sensitivities.md) by these constants; where there are none (friction, jumps, memory),
they are differences of runs, and it says so. Two constants of a bar took 4 runs instead of 10 on
the same synthetic data. `calibration.json` has the constants with their 95 % intervals and their
covariance (in the order and units of the constants).

## Choosing

| what you have | law |
| --- | --- |
| a data sheet's modulus only, stretch below 1.4 | neo_hookean |
| a uniaxial test to large stretch | yeoh; arruda_boyce, gent, fung to be stable beyond it |
| uniaxial and planar or equibiaxial tests | ogden of order 2 or 3, mooney_rivlin |
| a knitted or coated fabric, course and wale | holzapfel |
| paper, film, woven fabric, printed fittings | linear |

`softact fit DATA --law all` compares them on your data. A law with a negative constant must not be
used beyond the stretch it was fitted to; the fit says where it becomes unstable.
"""

LOOKED_FOR = (
    (
        "Dragon Skin 20, Mold Star 16, PlatSil Gel 10",
        "yes: tensile tests of the Soft Robotics Materials Database (Marechal et al. 2020, doi "
        "10.1089/soro.2019.0115), fitted with `softact fit --law ogden_1` up to a stretch of 4",
    ),
    (
        "Mold Star 15, Smooth-Sil 950",
        "constants in programs that say nothing of the test; not taken",
    ),
    ("Smooth-Sil 940, Ecoflex 00-20, latex", "no"),
    (
        "PDMS Sylgard 184",
        "no; a paper on a PDMS (Phothiphatcha and Puttapitukporn 2021, doi 10.4186/ej.2021.25.4) "
        "of which only the abstract could be read",
    ),
    (
        "TPU 85A and 95A, Agilus30, Elastic 80A",
        "no; a paper on 14 printable materials (doi 10.1089/3dp.2023.0010) may have some, but only "
        "its beginning could be read",
    ),
)


def looked_for() -> list[str]:
    """What cards were looked for, and what came of it."""
    return [
        "",
        "## Cards that were looked for",
        "",
        "On 28 November 2026, in papers, public repositories and web pages. A card needs "
        "constants, or data to fit, and the test that they are from.",
        "",
        "| material | found |",
        "| --- | --- |",
        *(f"| {material} | {found} |" for material, found in LOOKED_FOR),
    ]


READING = """
## What `softact fit` reads

A table as the testing machine wrote it: separated by commas, semicolons, tabs or blanks, in UTF-8,
UTF-16 or Latin-1, with decimal points or commas, with cells in quotes, with text, a table of
results and sizes of the specimen above it, with a row of units under the names. `#` begins a
comment. Cells such as `N/A` have no value, and their rows are left out. Several tables under the
same headings, or a column `specimen`, are several specimens.

- Headings are understood by their words, in English, German and French: `Tensile strain (%)`,
  `Standard force [N]`, `Load Cell (N)`, `lambda`, `Stretch ratio`, `Extension (in)`,
  `Kraft in N`. `kg/cm^2` is read as kgf/cm², `Load (kg)` as a weight, and that is said. Times,
  counters and curves of a fit are left out.
- Where a file has several measures, strain and nominal stress win over extension and load, since
  they need no sizes and a strain may come from an extensometer. `--length` asks for the extension,
  `--area` or `--width` and `--thickness` for the load; `--columns` names each column, `-` skips
  one. What was taken is said, and so is a cross-section or a gauge length that the columns
  contradict.
- `tensile stress` and `compressive stress` are force per undeformed area, as ISO 37 and ISO 527
  have it. What a `stress` is, a load beside it tells; else `--stress` has to.
- The break, a sudden fall of the stress that never recovers, and a hold at the end, in which the
  material relaxes, are left out and told; `--whole` keeps them. Unloading and cycles are refused
  without `--loading` or `--cycle`.
- `--broke` says that the specimens broke where their tests end: the card gets the mean nominal
  stress and elongation of these points, so that runs with it tell failure pressures. Whatever
  `--to` leaves of the curve for the fit, the whole of it counts here. Of uniaxial tension alone;
  in a list of tests, `broke: true` stands at those that broke.
- A file that cannot be read as it is is refused with the command that reads it.

Measured curves for `softact run --measured`, `softact report --measured` and
`softact calibrate --data` are read by the same rules; their headings name columns of `curve.csv`.
"""

FITTING = """
## What `softact fit` reports

The data are nominal or Cauchy stress over stretch, strain or displacement in uniaxial tension or
compression, equibiaxial or planar tension, or biaxial tests of a sheet with fibres. The stress of a
law in these modes is the derivative of its energy along the incompressible path.

- Constants with 95 % confidence intervals: linearised, Student's t. Points of one curve are not
  independent, so that the intervals are lower limits; the scatter between specimens says more.
- R² and RMSE per test, in nominal stress. Reduced chi-square Σ((law − data)/σ)²/(n − p) with σ from
  `--sigma` or from the scatter between specimens. ε = √(Σ(law − data)²/(n − p)) / mean stress, the
  figure used for fabrics and tissue.
- Drucker stability: the range of stretch over which the matrix of Cauchy stress against logarithmic
  strain in plane stress is positive definite, in all three modes. A mode that was not tested is
  judged up to the Ī1 that the tests reached.
- Constants that the data do not determine. Planar tests alone, for instance, determine only
  c10 + c01 of Mooney-Rivlin.
- With `--relative`, residuals are parts of the law's own stress, found by weighing anew until the
  constants stay: parts of the measured stress would count points that noise makes small more than
  others, and 3 % of scatter would make a modulus 0.18 % too small. Where the stress is below 2 % of
  the largest of its test, the residual is a part of these 2 %, or a few points near zero load would
  outweigh the curve.
- AICc and BIC, which are small for a law that follows the points and has few constants.
- `--law all` looks further: at the error over the tests, at the error over what was held out of the
  fit (each mode in turn; of one mode each quarter of the stretch), and at the constants. The law
  with the smallest √(error · error held out) · n^(c/2n) is first. c counts the constants, those
  that are poorly determined twice, and n the independent residuals: n (1 − ρ)/(1 + ρ) of n points
  whose neighbours correlate by ρ. The last factor is Bayes' criterion written as an error. Laws
  that are unstable within the tests, or that the tests do not determine, come last. One sentence
  says why the first is first.

Ogden's moduli are kept positive (Abaqus's convention), which makes the law stable at any stretch.
Nothing is smoothed, trimmed or shifted unless an option asks for it, but a break and a hold at the
end, and whatever is done is said.

What the floor of 2 % is worth, `.venv/bin/python -m benchmarks.relative_floor`: 60 drawn tests to a
stretch of 2 with 3 % of scatter and a load cell whose zero is off, by so much of the largest stress
(standard deviation). How far the mean of a constant is off, and how far one test scatters. Without
an error of the zero it changes nothing; with one, it keeps the constants of a test closer together.

| law | zero off by | floor | c10 | c20 |
| --- | --- | --- | --- | --- |
| neo_hookean | 0 % | 0 % | +0.00 ± 0.3 % |  |
| neo_hookean | 0 % | 2 % | +0.00 ± 0.3 % |  |
| neo_hookean | 0 % | 5 % | +0.00 ± 0.3 % |  |
| neo_hookean | 0.5 % | 0 % | -0.13 ± 1.9 % |  |
| neo_hookean | 0.5 % | 2 % | -0.12 ± 1.8 % |  |
| neo_hookean | 0.5 % | 5 % | -0.10 ± 1.6 % |  |
| reduced_polynomial_2 | 0 % | 0 % | +0.01 ± 0.6 % | -0.06 ± 1.9 % |
| reduced_polynomial_2 | 0 % | 2 % | +0.01 ± 0.5 % | -0.05 ± 1.8 % |
| reduced_polynomial_2 | 0 % | 5 % | +0.03 ± 0.5 % | -0.12 ± 1.8 % |
| reduced_polynomial_2 | 0.5 % | 0 % | -0.61 ± 7.1 % | +1.57 ± 14.9 % |
| reduced_polynomial_2 | 0.5 % | 2 % | -0.37 ± 5.7 % | +0.84 ± 11.2 % |
| reduced_polynomial_2 | 0.5 % | 5 % | -0.25 ± 4.5 % | +0.45 ± 8.0 % |
"""


def constants(law: type[Law]) -> list[str]:
    """The table of a law's own constants."""
    lines = ["| constant | unit | default | meaning |", "| --- | --- | --- | --- |"]
    for name, entry in law.model_fields.items():
        if name == "law" or (name in Law.model_fields and not entry.is_required()):
            continue
        dimension = dimension_of(entry)
        unit = dimension.internal if dimension else ""
        default = "needed" if entry.is_required() else entry.default
        default = "" if default is None else default
        lines.append(f"| `{name}` | {unit} | {default} | {entry.description or ''} |")
    return lines


def laws() -> list[str]:
    """A section per law."""
    lines = ["", "## Laws"]
    for name, law in LAWS.items():
        lines += ["", f"### {name}", "", f"`{law.formula}`", "", law.use, ""]
        lines += [*constants(law), "", f"Source: {law.reference}."]
    return lines


def cards() -> list[str]:
    """A section per card."""
    lines = ["", "## Cards"]
    skip = ("name", "law", "source", "test", "strength", "stretch_range", "notes", "density")
    skip += ("strength_is", "elongation", "strength_source")
    for name in CARDS:
        data = card_data(name)
        values = ", ".join(f"{key} {value}" for key, value in data.items() if key not in skip)
        lines += ["", f"### {name}", "", f"{data['law']}: {values}.", ""]
        lines.append(f"- density {data['density']}")
        if "strength" in data:
            lines.append(f"- strength {data['strength']}, {data['strength_is']}")
        if "elongation" in data:
            lines.append(f"- elongation at break {100 * data['elongation']:g} %")
        if "strength_source" in data:
            lines.append(f"- strength and elongation: {data['strength_source']}")
        if "stretch_range" in data:
            low, high = data["stretch_range"]
            lines.append(f"- tested to a stretch of {high:g}" + (f", from {low:g}" * (low < 1)))
        lines += [f"- {key}: {data[key]}" for key in ("test", "notes", "source") if key in data]
    return lines


def page() -> str:
    """The whole page."""
    return "\n".join(
        [
            INTRODUCTION.rstrip(),
            *laws(),
            *cards(),
            *looked_for(),
            READING.rstrip(),
            FITTING.rstrip(),
            "",
        ]
    )


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
    print(f"wrote {PAGE}")
