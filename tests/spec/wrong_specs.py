"""A spec that is right, and what makes it wrong: case -> text and [(line, path, words)], the faults
that ``softact`` has to tell of it. Lines count those of BASE and are written by hand.
"""

from itertools import pairwise

BASE = """\
name: finger
geometry:
  type: pneunet
  chambers: 4
  outer_wall: 1 mm
  roof: 1 mm
materials:
  body: elastosil-m4601
layers:
  - {surface: strain_limiting_layer, thickness: 0.1 mm, material: paper}
supports:
  - {surface: clamp, fix: [x, y, z]}
steps:
  - {name: gravity, gravity: [0, 0, -1]}
  - {name: inflate, pressure: 50 kPa}
measures: [bending, tip]
solver:
  tolerance: 1e-8
"""
INFLATE, SUPPORT, LAYER = 15, 12, 10


def changed(line, text):
    """BASE with one of its lines replaced."""
    lines = BASE.splitlines()
    assert 1 <= line <= len(lines)
    lines[line - 1] = text
    return "\n".join(lines) + "\n"


def step(text):
    return changed(INFLATE, f"  - {{name: inflate, {text}}}")


def support(text):
    return changed(SUPPORT, f"  - {text}")


def layer(text):
    return changed(LAYER, f"  - {text}")


def body(text):
    return changed(8, f"  body: {text}")


def solver(text):
    return changed(18, f"  {text}")


# name of the case: text of the spec, [(line, path, words), ...] one for each fault
WRONG = {
    # units and numbers
    "no unit": (changed(5, "  outer_wall: 1"), [(5, "geometry.outer_wall", "'1' has no unit")]),
    "no unit, quoted": (changed(5, "  outer_wall: '1'"), [(5, "geometry.outer_wall", "no unit")]),
    "length as pressure": (step("pressure: 50 mm"), [(15, "steps.1.pressure", "is a length")]),
    "mass as pressure": (step("pressure: 5 kg"), [(15, "steps.1.pressure", "is a mass")]),
    "bare pressure": (
        step("pressure: 50"),
        [(15, "steps.1.pressure", "'50' has no unit; write a pressure, for example '50 kPa'")],
    ),
    "unit in the wrong case": (
        step("pressure: 50 kpa"),
        [(15, "steps.1.pressure", "there is no unit 'kpa'; did you mean 'kPa'?")],
    ),
    "unknown unit": (step("pressure: 50 foo"), [(15, "steps.1.pressure", "no unit 'foo'")]),
    "pressure as a list": (
        step("pressure: [50 kPa]"),
        [(15, "steps.1.pressure", "not a pressure")],
    ),
    "true as a pressure": (step("pressure: true"), [(15, "steps.1.pressure", "not a pressure")]),
    "nan": (changed(6, "  roof: .nan"), [(6, "geometry.roof", "'nan' is not a finite number")]),
    "nan with unit": (changed(6, "  roof: nan mm"), [(6, "geometry.roof", "not a finite")]),
    "pressure injected": (step("inject: 5 kPa"), [(15, "steps.1.inject", "is a pressure")]),
    "injected elsewhere": (
        step("inject: {upper: 2 ml}"),
        [(15, "steps.1.inject.upper", "no cavity 'upper'; known: cavity")],
    ),
    "pressure and volume at once": (
        step("pressure: 5 kPa, inject: 2 ml"),
        [(15, "steps.1.inject", "drive a cavity by one of them")],
    ),
    "infinity": (step("pressure: -inf kPa"), [(15, "steps.1.pressure", "not a finite number")]),
    "overflow": (changed(6, "  roof: 1e999 mm"), [(6, "geometry.roof", "too large")]),
    "decimal comma": (changed(6, "  roof: '1,5 mm'"), [(6, "geometry.roof", "decimal comma")]),
    "arithmetic": (changed(6, "  roof: 9**9**9 mm"), [(6, "geometry.roof", "no unit")]),
    "nan without dimension": (
        solver("tolerance: .nan"),
        [(18, "solver.tolerance", "not a finite")],
    ),
    "unit where none fits": (solver("tolerance: 1 mm"), [(18, "solver.tolerance", "has a unit")]),
    # unknown and missing keys, wrong types
    "unknown key": (changed(1, "nam: x"), [(1, "nam", "unknown key; did you mean 'name'?")]),
    "unknown parameter": (
        changed(5, "  outer_wal: 1 mm"),
        [(5, "geometry.outer_wal", "unknown key; did you mean 'outer_wall'?")],
    ),
    "unknown key of a step": (
        step("presure: 5 kPa"),
        [
            (15, "steps.1.presure", "did you mean 'pressure'?"),
        ],
    ),
    "unknown key of the solver": (solver("tol: 1"), [(18, "solver.tol", "'tolerance'")]),
    "no geometry type": (
        changed(3, "  base: 2 mm"),
        [
            (2, "geometry.type", "missing; write one of: "),
        ],
    ),
    "unknown geometry": (
        changed(3, "  type: pnuenet"),
        [(3, "geometry.type", "there is no geometry 'pnuenet'; did you mean 'pneunet'?")],
    ),
    "geometry as a word": (
        "geometry: pneunet\nmaterials: {body: paper}\nsteps: [{pressure: 1 Pa}]",
        [
            (1, "geometry", "'pneunet' is given; write a mapping with 'type'"),
        ],
    ),
    "no geometry at all": (
        "materials: {body: paper}\nsteps: [{gravity: [0, 0, 1]}]",
        [
            (1, "geometry", "missing; type and parameters"),
        ],
    ),
    "nothing but a name": (
        "name: finger",
        [
            (1, "geometry", "missing"),
            (1, "steps", "missing"),
            (1, "materials", "missing"),
        ],
    ),
    "fraction of a chamber": (changed(4, "  chambers: 4.5"), [(4, "geometry.chambers", "whole")]),
    "chambers as text": (
        changed(4, "  chambers: four"),
        [(4, "geometry.chambers", "whole number")],
    ),
    "name with a slash": (changed(1, "name: ../finger"), [(1, "name", "is no name here")]),
    "name as a number": (changed(1, "name: 3"), [(1, "name", "text is wanted")]),
    "steps as a mapping": (
        "\n".join([*BASE.splitlines()[:12], "steps: {pressure: 50 kPa}"]),
        [(13, "steps", "a mapping is given; a list is wanted")],
    ),
    "a step that is a word": (changed(15, "  - inflate"), [(15, "steps.1", "a mapping")]),
    # impossible geometry
    "no chamber": (changed(4, "  chambers: 0"), [(4, "geometry.chambers", "at least 1")]),
    "negative wall": (changed(5, "  outer_wall: -1 mm"), [(5, "geometry.outer_wall", "-1 mm")]),
    "wall of nothing": (changed(6, "  roof: 0 mm"), [(6, "geometry.roof", "vanish")]),
    "no room for the chambers": (
        changed(6, "  length: 10 mm"),
        [(6, "geometry.length", "would vanish")],
    ),
    "channel wider than the chambers": (
        changed(6, "  channel_width: 20 mm"),
        [(6, "geometry.channel_width", "outer walls would vanish")],
    ),
    "layer outside the base, by a default": (
        changed(6, "  base: 0.5 mm"),
        [(2, "geometry.layer_height", "not inside the base")],
    ),
    # materials
    "unknown card": (
        body("elastosil-m4610"),
        [(8, "materials.body", "no material card 'elastosil-m4610'; did you mean 'elastosil-m46")],
    ),
    "unknown law": (
        body("{law: yeo, c10: 1 MPa}"),
        [(8, "materials.body.law", "there is no law 'yeo' here; did you mean 'yeoh'?")],
    ),
    "unknown constant": (
        body("{law: neo_hookean, c10: 1 MPa, c20: 1 MPa}"),
        [
            (8, "materials.body.c20", "unknown key; did you mean 'c10'?"),
        ],
    ),
    "constant without unit": (
        body("{law: yeoh, c10: 0.1}"),
        [(8, "materials.body.c10", "no unit")],
    ),
    "missing constant": (body("{law: yeoh}"), [(8, "materials.body.c10", "missing; write a pres")]),
    "neither card nor law": (
        body("{c10: 1 MPa}"),
        [(8, "materials.body", "neither 'card' nor 'law'")],
    ),
    "law of another card": (
        body("{card: elastosil-m4601, law: ogden}"),
        [(8, "materials.body", "elastosil-m4601")],
    ),
    "poissons ratio of 0.5": (
        body("{law: neo_hookean, c10: 1 MPa, poissons_ratio: 0.5}"),
        [(8, "materials.body.poissons_ratio", "'0.5' must be less than 0.5")],
    ),
    "negative density": (
        body("{card: elastosil-m4601, density: -1 kg/m^3}"),
        [(8, "materials.body.density", "'-1 kg/m^3' must be greater than 0")],
    ),
    "negative stiffness": (
        body("{law: neo_hookean, c10: -1 MPa}"),
        [(8, "materials.body", "must be positive")],
    ),
    "unknown region": (
        changed(8, "  bodi: elastosil-m4601"),
        [
            (7, "materials.body", "missing"),
            (8, "materials.bodi", "no region 'bodi'; did you mean 'body'?"),
        ],
    ),
    "no material": (body(""), [(8, "materials.body", "no value is given")]),
    "rubber as a layer": (
        layer("{surface: strain_limiting_layer, thickness: 1 mm, material: elastosil-m4601}"),
        [(10, "layers.0.material", "another law than a layer can have: linear")],
    ),
    # names of surfaces and cavities
    "unknown surface of a layer": (
        layer("{surface: strain_limiting, thickness: 1 mm, material: paper}"),
        [(10, "layers.0.surface", "did you mean 'strain_limiting_layer'?")],
    ),
    "layer of no thickness": (
        layer("{surface: strain_limiting_layer, thickness: 0 mm, material: paper}"),
        [(10, "layers.0.thickness", "'0 mm' must be greater than 0")],
    ),
    "unknown surface of a support": (
        support("{surface: clmap, fix: [x, y, z]}"),
        [(12, "supports.0.surface", "no surface 'clmap'; did you mean 'clamp'?")],
    ),
    "unknown cavity": (
        step("pressure: {upper: 50 kPa}"),
        [(15, "steps.1.pressure.upper", "no cavity 'upper'; known: cavity")],
    ),
    "two cavities of one name": (
        step("pressure: {cavity: 50 kPa, cavity: 20 kPa}"),
        [(15, "steps.1.pressure.cavity", "given twice, first in line 15; keep one")],
    ),
    "traction on no surface": (
        step("traction: {surface: top, value: [0 kPa, 0 kPa, 1 kPa]}"),
        [(15, "steps.1.traction.surface", "no surface 'top'")],
    ),
    "pressure on no surface": (
        step("surface_pressure: {top: 1 kPa}"),
        [(15, "steps.1.surface_pressure.top", "no surface 'top'")],
    ),
    "surface pressure without a surface": (
        step("surface_pressure: 1 kPa"),
        [(15, "steps.1.surface_pressure", "a mapping 'key: value' is wanted")],
    ),
    # supports
    "fixed and moved": (
        support("{surface: clamp, fix: [x, y, z], move: {x: 1 mm}}"),
        [(12, "supports.0", "'x' is both fixed and moved")],
    ),
    "fixed in an unknown direction": (
        support("{surface: clamp, fix: [x, y, w]}"),
        [
            (11, "supports", "nothing holds the actuator along z"),
            (12, "supports.0.fix.2", "'w' is not one of: x, y, z"),
        ],
    ),
    "moved by a pressure": (
        support("{surface: clamp, fix: [y, z], move: {x: 1 kPa}}"),
        [(12, "supports.0.move.x", "is a pressure; write a length")],
    ),
    "support of nothing": (
        support("{surface: clamp}"),
        [
            (11, "supports", "nothing holds the actuator along x"),
            (11, "supports", "nothing holds the actuator along z"),
            (12, "supports.0", "neither fixes nor moves"),
        ],
    ),
    "held in one direction only": (
        support("{surface: clamp, fix: [x]}"),
        [(11, "supports", "nothing holds the actuator along z")],
    ),
    "held twice": (
        support("{surface: clamp, fix: [x, y, z]}\n  - {surface: clamp, move: {z: 1 mm}}"),
        [(13, "supports.1", "'z' of 'clamp' is held by another support already")],
    ),
    # steps
    "two steps of one name": (
        changed(15, "  - {name: gravity, pressure: 50 kPa}"),
        [(15, "steps.1.name", "'gravity' is the name of steps.0 too")],
    ),
    "no steps": (
        "\n".join([*BASE.splitlines()[:12], "steps: []"]),
        [(13, "steps", "no step is given")],
    ),
    "a step of nothing": (changed(15, "  - {name: hold}"), [(15, "steps.1", "changes nothing")]),
    "gravity of two components": (
        changed(14, "  - {name: gravity, gravity: [0, -1]}"),
        [(14, "steps.0.gravity", "2 values are given; write a list of three")],
    ),
    "gravity as a velocity": (
        changed(14, "  - {name: gravity, gravity: [0 m/s^2, 0 m/s^2, -9.81 m/s]}"),
        [(14, "steps.0.gravity.2", "is a velocity; write an acceleration")],
    ),
    "gravity in bare m/s^2": (
        changed(14, "  - {name: gravity, gravity: [0, 0, -9.81]}"),
        [(14, "steps.0.gravity", "without unit counts in g")],
    ),
    # measures and solver
    "unknown measure": (
        changed(16, "measures: [bendin, tip]"),
        [(16, "measures.0", "there is no measure 'bendin'; did you mean 'bending'?")],
    ),
    "tile that no measure has": (
        changed(16, "tiles: [blocked_force_M]"),
        [(16, "tiles.0", "a column 'blocked_force_M'; did you mean 'blocked_force_N'?")],
    ),
    "tile of a measure left out": (
        changed(16, "measures: [tip]\ntiles: [pull_N]"),
        [(17, "tiles.0", "'pull_N' is of measure reaction, which 'measures' leaves out")],
    ),
    "no measures": (changed(16, "measures: []"), [(16, "measures", "write 'all' or a list")]),
    "loose tolerance": (solver("tolerance: 0.5"), [(18, "solver.tolerance", "at most 0.01")]),
    "tolerance of nothing": (solver("tolerance: 0"), [(18, "solver.tolerance", "greater than 0")]),
    "unknown element": (
        solver("element: P3"),
        [(18, "solver.element", "'P3' is not one of: P2/P1")],
    ),
    "increments out of order": (
        solver("min_increment: 0.5"),
        [(17, "solver", "min_increment <= initial_increment <= max_increment")],
    ),
    # the file itself
    "empty": ("", [(None, None, "the file is empty")]),
    "comments only": ("# nothing\n\n", [(None, None, "the file is empty")]),
    "a word": ("finger", [(1, None, "a spec is a mapping")]),
    "a list": ("- name: finger\n", [(1, None, "a spec is a mapping")]),
    "a tab": (changed(4, "\tchambers: 4"), [(4, None, "a tab cannot indent")]),
    "an open bracket": (changed(16, "measures: [bending"), [(17, None, "not valid YAML")]),
    "two documents": (BASE + "---\n" + BASE, [(19, None, "a second document starts here")]),
    "a key twice": (
        changed(6, "  chambers: 5"),
        [
            (6, "geometry.chambers", "given twice, first in line 4; keep one"),
        ],
    ),
    "a merge key": (changed(6, "  <<: {roof: 1 mm}"), [(6, "geometry.<<", "merge keys")]),
    "a key that is a list": (
        changed(6, "  ? [a, b]\n  : 1 mm"),
        [(6, "geometry", "a key must be")],
    ),
    "a Python object": (
        changed(6, "  roof: !!python/object/apply:os.system ['touch owned']"),
        [(6, "geometry.roof", "the tag")],
    ),
    "a local tag": (changed(6, "  roof: !thing 1 mm"), [(6, "geometry.roof", "tag '!thing'")]),
    "a billion values": (
        "a: &a [x, x, x, x, x, x, x, x, x]\n"
        + "".join(f"{b}: &{b} [{', '.join([f'*{a}'] * 9)}]\n" for a, b in pairwise("abcdefghi")),
        [(None, None, "aliases expand to more than 20000 values")],
    ),
    "an alias of itself": ("a: &a [*a]\n", [(1, None, "an alias that holds itself")]),
    "an alias of nothing": (changed(6, "  roof: *wall"), [(6, None, "undefined alias 'wall'")]),
    "deep nesting": ("a: " + "[" * 5000, [(1, None, "nested too deeply")]),
    "nesting of 100": ("a: " + "[" * 100 + "]" * 100, [(1, None, "nested too deeply")]),
    "values without end": ("a: [" + "1," * 400_000 + "]", [(1, None, "more than 20000 values")]),
    "half of a character": (changed(1, 'name: "\\ud800"'), [(1, "name", "half of a character")]),
    "a name that is half of a character": (
        changed(6, '  "\\udc00": 1 mm'),
        [(6, "geometry", "half of a character")],
    ),
    "blanks in a value": (
        changed(6, "  roof: '1,1" + " " * 900_000 + "1'"),
        [(6, "geometry.roof", "decimal comma")],
    ),
    "digits in a value": (
        changed(6, "  roof: '" + "1,1" * 300_000 + "'"),
        [(6, "geometry.roof", "decimal comma")],
    ),
    "a power of a power": (
        changed(6, "  roof: 1 m^9^9^9"),
        [(6, "geometry.roof", "there is no unit 'm^9^9^9'")],
    ),
    "a mass per area": (
        step("pressure: 1 kg/cm^2"),
        [(15, "steps.1.pressure", "is a mass per area; did you mean 'kgf/cm^2'?")],
    ),
    "a control character": ("name: a\x07b\n", [(1, None, "a control character")]),
    "binary": (b"\x7fELF\x02\x01\x01\0\0\0", [(None, None, "this is not a text file")]),
    "another encoding": ("name: größe".encode("latin-1"), [(None, None, "not a text file")]),
    "UTF-16": (BASE.encode("utf-16"), [(None, None, "this is not a text file")]),
    "a large file": (b"# " + b"x" * 1_000_000, [(None, None, "larger than 1000 kB")]),
}
