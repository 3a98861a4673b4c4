"""Units as machines and spreadsheets spell them."""

import pytest

from softact.measured import spelling
from softact.units import FORCE, LENGTH, PRESSURE


@pytest.mark.parametrize(
    ("text", "dimension", "expected"),
    [
        ("N/mm2", PRESSURE, 1.0), ("Kgf/cm2.", PRESSURE, 0.0980665),
        ("kg/cm^2", PRESSURE, 0.0980665),
        ("LB/IN2", PRESSURE, 6.894757293e-3), ("[kN/m²]", PRESSURE, 1e-3), ("KPA", PRESSURE, 1e-3),
        ("N/sq.mm", PRESSURE, 1.0), ("mPa", PRESSURE, 1.0), ("inches", LENGTH, 25.4),
        ("MM", LENGTH, 1.0), ("KN", FORCE, 1e3), ("MN", FORCE, 1e6), ("mN", FORCE, 1e-3),
        ("lbs", FORCE, 4.4482216153), ("g", FORCE, 9.80665e-3), ("Newton", FORCE, 1.0),
    ],
)  # fmt: skip
def test_units_as_machines_spell_them(text, dimension, expected):
    unit = spelling.registry_unit(text, dimension)
    assert dimension.parse(f"1 {unit}") == pytest.approx(expected)


def test_every_spelling_is_a_unit_of_the_registry():
    tables = (spelling._LENGTHS, LENGTH), (spelling._FORCES, FORCE), (spelling._PRESSURES, PRESSURE)
    for table, dimension in tables:
        for unit in table.values():
            assert dimension.parse(f"1 {unit}") > 0
    for text in ("Load", "Strain", "", "1", "N/mm", "mm/N", "N/mm3", "bananas", "N/mm2/s"):
        assert spelling.registry_unit(text, PRESSURE) is None
