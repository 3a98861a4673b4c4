"""`softact fit`: a law's constants from tensile tests."""

import re
from collections.abc import Callable
from pathlib import Path

import click
from click.core import ParameterSource

from softact.cli._force import force_option

LAWS = (
    "neo_hookean, mooney_rivlin_2 (3, 5, 9), yeoh, reduced_polynomial_1 to _6, ogden_1 to _6, "
    "arruda_boyce, van_der_waals, gent, fung, holzapfel, or all"
)


def _quantity(
    name: str,
) -> Callable[[click.Context, click.Parameter, str | None], float | None]:
    """A click callback that reads a value with its unit by the dimension of that name."""

    def read(ctx: click.Context, parameter: click.Parameter, value: str | None) -> float | None:
        if value is None:
            return None
        import softact.units

        try:
            number = getattr(softact.units, name).parse(value)
        except ValueError as error:
            raise click.BadParameter(str(error)) from None
        if number <= 0:
            raise click.BadParameter(f"'{value}' must be positive")
        return number

    return read


def _file_name(ctx: click.Context, parameter: click.Parameter, value: str | None) -> str | None:
    if value is not None and not re.fullmatch(r"[\w.-]*\w[\w.-]*", value):
        raise click.BadParameter(f"'{value}' is no name for files; use letters, digits, . _ -")
    return value


def _pairs(
    ctx: click.Context, parameter: click.Parameter, values: tuple[str, ...]
) -> dict[str, str]:
    pairs = {}
    for value in values:
        name, equals, text = value.partition("=")
        if not equals or not name or not text:
            raise click.BadParameter(f"'{value}' is not of the form name=value")
        pairs[name.strip()] = text.strip()
    return pairs


def _check_unused(context: click.Context) -> None:
    """Refuse options that a fit of memory would pass over."""
    for name in ("relative", "method", "starts", "seed", "sigma", "fix", "compare", "broke"):
        if context.get_parameter_source(name) is ParameterSource.COMMANDLINE:
            raise click.UsageError(f"--{name} does not go with --cyclic, --rates and --creep")


@click.command(short_help="Fit a law to tensile tests and write a material card.")
@click.argument("data", nargs=-1, required=True, metavar="FILE[:MODE[@DIRECTION]]...")
@click.option("--law", default="yeoh", show_default=True, help=LAWS + ".")
@click.option("--columns", help="Headings in order, where the file has none or unclear ones.")
@click.option("--stress", type=click.Choice(["nominal", "cauchy"]), help="What 'stress' holds.")
@click.option("--length", help="Gauge length of the specimen, such as '33 mm'.")
@click.option("--width", help="Width of the specimen.")
@click.option("--thickness", help="Thickness of the specimen.")
@click.option("--area", help="Cross-section of the specimen, such as '18 mm^2'.")
@click.option("--loading", is_flag=True, help="Keep the first loading only.")
@click.option("--cycle", help="Keep the loading of this cycle: 1, 2, ... or last.")
@click.option("--whole", is_flag=True, help="Keep the break, and a hold at the end.")
@click.option(
    "--broke",
    is_flag=True,
    help="The specimens broke at their last points: strength and elongation for the card.",
)
@click.option("--zero", is_flag=True, help="Subtract the stress of the first point.")
@click.option("--toe", help="Drop points below this stress, shift the zero of strain.")
@click.option("--from", "stretch_from", type=float, help="Smallest stretch to use.")
@click.option("--to", "stretch_to", type=float, help="Largest stretch to use.")
@click.option("--smooth", type=int, help="Savitzky-Golay window in points.")
@click.option("--points", type=int, help="Thin every test to so many points.")
@click.option(
    "--relative",
    is_flag=True,
    help="Residuals in parts of the law's stress; where that is below 2 % of a test's largest, in "
    "parts of these 2 %.",
)
@click.option("--balance", is_flag=True, help="Let every test count alike.")
@click.option(
    "--method",
    default="least-squares",
    show_default=True,
    help="least-squares, L-BFGS-B, Nelder-Mead, Powell, CG, COBYLA or SLSQP.",
)
@click.option(
    "--starts",
    type=click.IntRange(1, 200),
    default=8,
    show_default=True,
    help="Starts of the optimiser.",
)
@click.option(
    "--seed",
    type=click.IntRange(0, 2**32 - 1),
    default=0,
    show_default=True,
    help="Of the drawn starts.",
)
@click.option("--sigma", callback=_quantity("PRESSURE"), help="Standard deviation of the stress.")
@click.option(
    "--fix",
    multiple=True,
    callback=_pairs,
    metavar="NAME=VALUE",
    help="Hold a constant, such as beta=0 or families=1.",
)
@click.option(
    "--compare", multiple=True, metavar="CARD", help="Draw a card or a card's file beside it."
)
@click.option(
    "--relaxation",
    is_flag=True,
    help="FILEs are relaxation tests: time and stress (or force) at a held stretch; prints the "
    "Maxwell elements for a material, and writes nothing.",
)
@click.option(
    "--cyclic",
    is_flag=True,
    help="FILEs are loadings and unloadings: fits Mullins' softening (r, m, beta) beside the law.",
)
@click.option(
    "--rates",
    is_flag=True,
    help="FILEs have a time column, at one or more rates: fits Maxwell elements beside the law; "
    "with --cyclic both.",
)
@click.option(
    "--creep",
    is_flag=True,
    help="As --rates, of tests under a held stress: residuals count as stretch.",
)
@click.option("--density", callback=_quantity("DENSITY"), help="For the card.")
@click.option("--strength", callback=_quantity("PRESSURE"), help="Tensile strength, for the card.")
@click.option("--name", callback=_file_name, help="Name of the card; default: the first file's.")
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    default=Path("results/fit"),
    show_default=True,
    help="Folder for card, plot and numbers.",
)
@force_option
@click.pass_context
def fit(
    context: click.Context,
    data: tuple[str, ...],
    law: str,
    relative: bool,
    balance: bool,
    method: str,
    starts: int,
    seed: int,
    sigma: float | None,
    fix: dict[str, str],
    compare: tuple[str, ...],
    relaxation: bool,
    cyclic: bool,
    rates: bool,
    creep: bool,
    density: float | None,
    strength: float | None,
    name: str | None,
    output: Path,
    force: bool,
    **reading: object,
) -> None:
    """Fit a law to tests in homogeneous deformation; write a card, a plot and the numbers.

    MODE is uniaxial (the default), compression, equibiaxial, planar or biaxial; DIRECTION is
    course or wale, for fabrics. Headings name quantity and unit: 'stretch', 'strain %',
    'nominal stress (MPa)', 'cauchy_stress_kPa', 'displacement mm', 'force N', in the words of the
    testing machine too; what cannot be read is refused with the command that reads it. The break
    is left out. A YAML file in place of FILE lists tests that are read differently.

    \b
    Examples:
      softact fit tension.csv --law all
      softact fit uni.csv:uniaxial sheet.csv:planar --law ogden_3 --loading
      softact fit treloar.txt --columns 'nominal_stress MPa, stretch' --law yeoh
      softact fit held.csv --relaxation
      softact fit loops.csv --cyclic --law ogden_2
      softact fit slow.csv fast.csv --rates
    """
    if relaxation and (cyclic or rates or creep):
        raise click.UsageError("--relaxation does not go with --cyclic, --rates and --creep")
    if relaxation:
        from softact.fit import relaxation as tests

        for entry in data:
            path = Path(entry)
            test = tests.read_relaxation(path)
            for line in tests.tell(test, tests.fit_series(test), path.name):
                click.echo(line)
        return
    if strength is not None and reading["broke"]:
        raise click.UsageError("--broke and --strength both give the strength; give one")
    from softact.fit.fit import Options
    from softact.fit.run import Request, run
    from softact.fit.sheet import sheets_from_argument

    given = {field: value for field, value in reading.items() if value not in (None, False)}
    sheets = [sheet for entry in data for sheet in sheets_from_argument(entry, given)]
    if cyclic or rates or creep:
        from softact.fit.memory_run import MemoryRequest
        from softact.fit.memory_run import run as run_memory

        _check_unused(context)
        whole = MemoryRequest(
            sheets=sheets,
            law=law,
            directory=output,
            name=name or sheets[0].file.stem,
            softens=cyclic,
            creeps=rates or creep,
            by_stretch=creep,
            balance=balance,
            density=density,
            strength=strength,
            force=force,
        )
        run_memory(whole, click.echo)
        return
    request = Request(
        sheets=sheets,
        law=law,
        directory=output,
        name=name or sheets[0].file.stem,
        options=Options(
            relative=relative,
            balance=balance,
            method=method,
            starts=starts,
            seed=seed,
            sigma=sigma,
        ),
        held=fix,
        compare=compare,
        density=density,
        strength=strength,
        force=force,
    )
    run(request, click.echo)
