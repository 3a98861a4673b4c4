"""Tables of a strip of 33 × 6 × 2 mm, neo-Hookean with C10 = 0.14 MPa: what is read is known."""

import numpy as np

from softact.fit.data import read_tests
from softact.fit.sheet import make_sheet

STRETCH = np.linspace(1.0, 2.5, 25)


NOMINAL = 2 * 0.14 * (STRETCH - STRETCH**-2)  # MPa


CAUCHY = NOMINAL * STRETCH


LENGTH, WIDTH, THICKNESS = 33.0, 6.0, 2.0


TRAVEL, FORCE = LENGTH * (STRETCH - 1), NOMINAL * WIDTH * THICKNESS


TIME = np.arange(len(STRETCH)) / 10


SIZES = {"length": "33 mm", "width": "6 mm", "thickness": "2 mm"}


def rows(*columns, separator=",", comma=False, quoted=False):
    lines = []
    for row in zip(*columns, strict=True):
        cells = [v if isinstance(v, str) else f"{v:.8f}" for v in row]
        cells = [c.replace(".", ",") if comma else c for c in cells]
        lines.append(separator.join(f'"{c}"' if quoted else c for c in cells))
    return lines


def write(folder, *lines, encoding="utf-8", name="strip.csv", end="\n"):
    path = folder / name
    path.write_bytes((end.join(lines) + end).encode(encoding))
    return path


def read(path, **fields):
    return read_tests(make_sheet({"file": path, **fields}, str(path)))


def assert_is_the_strip(test, stretch=STRETCH, stress=NOMINAL):
    assert np.allclose(test.stretch, stretch, rtol=1e-6)
    assert np.allclose(test.stress, stress, rtol=1e-5, atol=1e-7)


BLUEHILL = (
    "Ergebnistabelle 1",
    ";Probenbezeichnung;Dicke;Breite;Länge",
    ";;(mm);(mm);(mm)",
    '1;"S1";2,00;6,00;33,00',
    "",
    "Zeit;Weg;Kraft",
    "(s);(mm);(N)",
)


SQUEEZED = np.linspace(1.0, 0.6, 20)


SQUEEZE = 2 * 0.14 * (SQUEEZED - SQUEEZED**-2)  # MPa, negative
