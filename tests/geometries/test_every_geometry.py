"""What must hold for the mesh of every geometry, for its defaults and for other parameters."""

import numpy as np
import pytest

from softact.geometries import GEOMETRIES


def mm(value: float) -> str:
    return f"{value} mm"


def random_pneunet(seed: int) -> dict:
    """Parameters drawn so that each wall stays: built up from thicknesses, never cut down."""
    draw = np.random.default_rng(seed).uniform
    base, chamber_height, chamber_width = draw(1, 4), draw(6, 20), draw(5, 20)
    lengths = {
        "base": base,
        "layer_height": base * draw(0.2, 0.8),
        "chamber_height": chamber_height,
        "chamber_width": chamber_width,
        "chamber_length": draw(2, 10),
        "gap": draw(0.5, 3),
        "outer_wall": draw(0.5, 3),
        "inner_wall": draw(0.5, 3),
        "roof": draw(0.5, 3),
        "channel_width": chamber_width * draw(0.2, 0.9),
        "channel_height": chamber_height * draw(0.1, 0.4),
        "channel_roof": chamber_height * draw(0.1, 0.4),
        "clamp_plug": draw(1, 8),
        "tip_plug": draw(1, 8),
        "mesh_size": draw(2, 5),
    }
    values = {name: mm(length) for name, length in lengths.items()}
    return {"chambers": 1 + seed % 4, "symmetry": seed % 2 == 0, **values}


CASES = [
    ("block", {}),
    ("block", {"length": "7 mm", "width": "0.3 mm", "height": "11 mm", "mesh_size": "2 mm"}),
    ("thick_sphere", {}),
    ("thick_sphere", {"inner_radius": "3 mm", "outer_radius": "9 mm", "mesh_size": "1 mm"}),
    ("tube", {}),
    ("tube", {"inner_radius": "5 mm", "outer_radius": "5.5 mm", "mesh_size": "1 mm"}),
    ("tube", {"part": "half"}),
    ("tube", {"part": "whole"}),
    ("pneunet", {}),
    ("pneunet", {"chambers": 2, "symmetry": False, "cavity_mesh_size": "1 mm"}),
    ("pneunet", {"chambers": 2, "channel_width": "12 mm", "channel_height": "16 mm",
                 "channel_roof": "0.5 mm"}),
    *[("pneunet", random_pneunet(seed)) for seed in range(8)],
    ("slow_pneunet", {}),
    ("slow_pneunet", {"chambers": 2, "symmetry": False, "film_width": "9 mm"}),
    ("slow_pneunet", {"kind": "linear", "chambers": 3, "floor": "3 mm"}),
    ("slow_pneunet", {"chambers": 1, "tunnel_width": "8 mm", "tunnel_height": "8 mm"}),
    ("omnidirectional", {"modules": 3}),
    ("omnidirectional", {"modules": 2, "cavities": 4, "on_top": "wall", "gap": "2 mm"}),
    ("omnidirectional", {"modules": 2, "cavities": 4, "symmetry": True, "channels": False}),
    ("omnidirectional", {"modules": 2, "on_top": "wall", "symmetry": True, "top_wall": "2 mm"}),
    ("omnidirectional", {"modules": 1, "cavities": 5, "mesh_size": "2 mm"}),
    ("omnidirectional", {"modules": 2, "channels": False, "core_radius": "4 mm"}),
    ("omnidirectional", {"modules": 2, "segments": 2}),
    ("omnidirectional", {"modules": 1, "segments": 3, "symmetry": True, "channels": False}),
    ("antagonistic", {"chambers": 2}),
    ("antagonistic", {"chambers": 2, "symmetry": True}),
    ("antagonistic", {"chambers": 1, "symmetry": True, "in_plane": "lower", "top_wall": "3 mm"}),
    ("shell_reinforced", {}),
    ("shell_reinforced", {"kind": "linear", "cuts": 4, "symmetry": False}),
    ("shell_reinforced", {"kind": "linear", "cuts": 3, "strip": "5 mm", "mesh_size": "3 mm"}),
    ("shell_reinforced", {"cuts": 0, "symmetry": False}),
    ("fiber_reinforced", {"length": "40 mm"}),
    ("fiber_reinforced", {"length": "40 mm", "symmetry": False, "base_wall": "1 mm"}),
    ("bellows", {"convolutions": 3}),
    ("bellows", {"convolutions": 2, "fold_radius": "1.2 mm", "part": "half", "mesh_size": "2 mm"}),
    ("bellows", {"convolutions": 1, "pitch": "20 mm", "part": "whole", "wall": "2 mm"}),
    ("braided_muscle", {}),
    ("braided_muscle", {"part": "half", "length": "30 mm", "mesh_size": "2 mm"}),
    ("braided_muscle", {"part": "whole", "length": "20 mm", "wall": "3 mm", "braid": "2 mm"}),
    ("bending_tube", {"length": "30 mm"}),
    ("bending_tube", {"length": "30 mm", "chambers": 1, "sleeve": "1 mm"}),
    ("bending_tube", {"length": "20 mm", "chambers": 2, "symmetry": False, "through_wall": 2}),
    ("pneunet", {"module_alone": True}),
    ("pneunet", {"module_alone": True, "symmetry": False, "cavity_mesh_size": "1 mm"}),
    ("slow_pneunet", {"module_alone": True}),
    ("slow_pneunet", {"module_alone": True, "kind": "linear", "symmetry": False}),
    ("block", {"module_alone": True}),
    ("fiber_reinforced", {"module_alone": True}),
    ("antagonistic", {"module_alone": True}),
    ("antagonistic", {"module_alone": True, "symmetry": True}),
    ("antagonistic", {"module_alone": True, "module_of": "lower", "symmetry": True}),
    ("tube", {"module_alone": True}),
    ("tube", {"module_alone": True, "part": "half"}),
    ("tube", {"module_alone": True, "part": "whole"}),
    ("omnidirectional", {"module_alone": True}),
    ("omnidirectional", {"module_alone": True, "symmetry": True, "on_top": "wall"}),
    ("shell_reinforced", {"module_alone": True}),
    ("shell_reinforced", {"module_alone": True, "kind": "linear", "symmetry": False}),
    ("block", {"through_wall": 3}),
    ("thick_sphere", {"through_wall": 3}),
    ("tube", {"inner_radius": "5 mm", "outer_radius": "5.5 mm", "through_wall": 3}),
    ("pneunet", {"chambers": 2, "mesh_size": "4 mm", "through_wall": 2}),
    ("slow_pneunet", {"chambers": 2, "film_thickness": "2 mm", "through_wall": 3}),
    ("omnidirectional", {"modules": 1, "mesh_size": "8 mm", "through_wall": 2}),
    ("antagonistic", {"chambers": 1, "symmetry": True, "mesh_size": "2.5 mm", "through_wall": 2}),
    ("shell_reinforced", {"cuts": 1, "end": "8 mm", "mesh_size": "3 mm", "through_wall": 2}),
    ("fiber_reinforced", {"length": "30 mm", "mesh_size": "3 mm", "through_wall": 2}),
    ("bellows", {"convolutions": 1, "part": "half", "through_wall": 3}),
    ("braided_muscle", {"wall": "2 mm", "braid": "2 mm", "part": "whole", "through_wall": 5}),
]  # fmt: skip


@pytest.fixture(params=CASES, ids=[f"{name}-{i}" for i, (name, _) in enumerate(CASES)])
def geometry(request):
    name, parameters = request.param
    return GEOMETRIES[name].model_validate(parameters)


def solid_volume(geometry) -> float:
    """Closed-form volume of all regions together."""
    return sum(geometry.volumes()[region] for region in geometry.layout().regions)


def test_occ_solid_has_the_closed_form_volume(geometry, occ_volume):
    assert occ_volume(geometry) == pytest.approx(solid_volume(geometry), rel=1e-9)


def test_mesh_fills_the_solid_once(geometry, meshed):
    solid = meshed(geometry)
    assert solid.volumes.min() > 0
    wanted = solid_volume(geometry)
    assert solid.volumes.sum() == pytest.approx(wanted, rel=geometry.volume_tolerance("body"))
    assert max(len(cells) for cells in solid.faces.values()) == 2


def test_surfaces_are_the_skin_and_the_layers(geometry, meshed):
    """Each outer face is in exactly one surface, but for ``base`` and ``shell``, which are parts
    of ``outer``; each triangle of an embedded layer is a face of two cells."""
    solid = meshed(geometry)
    skin = sorted(face for face, cells in solid.faces.items() if len(cells) == 1)
    inside = sorted(face for face, cells in solid.faces.items() if len(cells) == 2)
    within = {"base": "outer", "shell": "outer"}
    named = [
        tuple(triangle)
        for name, triangles in solid.surfaces.items()
        if name not in solid.layout.layers and name not in within
        for triangle in triangles.tolist()
    ]
    assert sorted(named) == skin
    for name in set(solid.layout.layers) - set(within):
        layer = set(map(tuple, solid.surfaces[name].tolist()))
        assert layer and layer <= set(inside)
    for part, whole in within.items():
        if part in solid.surfaces:
            parts = set(map(tuple, solid.surfaces[part].tolist()))
            assert parts and parts <= set(map(tuple, solid.surfaces[whole].tolist()))


def test_surfaces_have_the_closed_form_areas(geometry, meshed):
    solid = meshed(geometry)
    for name in set(solid.surfaces) & set(geometry.volumes()) - set(solid.layout.cavities):
        area = np.linalg.norm(solid.outward_areas(name)[1], axis=1).sum()
        tolerance = geometry.volume_tolerance(name)
        assert area == pytest.approx(geometry.volumes()[name], rel=tolerance)


def test_cavities_close_and_hold_the_closed_form_volumes(geometry, meshed):
    if not geometry.layout().cavities:
        pytest.skip("this geometry is solid")
    solid = meshed(geometry)
    for cavity, walls in solid.layout.cavities.items():
        parts = [solid.outward_areas(wall) for wall in walls]
        middles, areas = (np.vstack(part) for part in zip(*parts, strict=True))
        open_axes = list(solid.layout.symmetry.values())
        leak = np.delete(areas.sum(axis=0), open_axes)
        assert np.abs(leak).max(initial=0) < 1e-9 * np.linalg.norm(areas, axis=1).sum()
        # Divergence theorem with the field (0, y, 0): a plane y = 0 and all planes normal to x or
        # z that close the cavity have no flux.
        volume = -(middles[:, 1] * areas[:, 1]).sum()
        tolerance = geometry.volume_tolerance(cavity)
        assert volume == pytest.approx(geometry.volumes()[cavity], rel=tolerance)


def test_ends_and_symmetry_lie_where_the_layout_says(geometry, meshed):
    solid = meshed(geometry)
    layout = solid.layout
    for name, axis in layout.symmetry.items():
        assert np.abs(solid.points[solid.surfaces[name]][..., axis]).max() < 1e-9
    assert layout.copies == 2 ** len(layout.symmetry)
    for name, at in ((layout.clamp, 0.0), (layout.tip, layout.length)):
        if name:
            along = (solid.points[solid.surfaces[name]] - layout.origin) @ layout.axis
            assert along == pytest.approx(at, abs=1e-9)


LEAST_QUALITY = {"omnidirectional": 0.06, "antagonistic": 0.06, "bending_tube": 0.14}


def test_no_slivers(geometry, meshed):
    """Mean ratio: 1 for a regular tetrahedron, 0.84 for the corner of a cube, 0.32 for that of a
    cell 10 x 10 x 1; gmsh's own Delaunay mesh of the PneuNet's walls has some at 0.04. Round
    sections have small faces where thin walls and circles cross."""
    solid = meshed(geometry)
    edges = [
        solid.points[solid.cells[:, i]] - solid.points[solid.cells[:, j]]
        for i in range(4)
        for j in range(i)
    ]
    squares = sum((edge**2).sum(axis=1) for edge in edges)
    quality = 12 * np.cbrt(3 * solid.volumes) ** 2 / squares
    assert quality.min() > LEAST_QUALITY.get(geometry.type, 0.15)
