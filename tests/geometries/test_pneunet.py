"""The PneuNet's own rules: how its lengths hang together, and what is refused."""

import numpy as np
import pytest
from pydantic import ValidationError

from softact.geometries.pneunet import Pneunet


def pneunet(**lengths):
    """A PneuNet from lengths in mm (and whole numbers and truths)."""
    return Pneunet.model_validate(
        {k: f"{v} mm" if isinstance(v, float) else v for k, v in lengths.items()}
    )


UNEVEN = {
    "chambers": 4,
    "chamber_lengths": ["5 mm", "6 mm", "7 mm", "8 mm"],
    "chamber_heights": ["16 mm", "12 mm", "14 mm", "10 mm"],
    "inner_walls": ["1 mm", "1.2 mm", "0.9 mm", "1.1 mm"],
    "roofs": ["1 mm", "1.5 mm", "1.2 mm", "2 mm"],
    "gaps": ["1 mm", "5 mm", "2 mm"],
}


def faults(**lengths) -> dict[str, str]:
    with pytest.raises(ValidationError) as caught:
        pneunet(**lengths)
    return {str(fault["loc"][0]): fault["msg"] for fault in caught.value.errors()}


def test_volume_of_one_counted_by_hand():
    """Two chambers 6 x 12 x 16 mm, walls 1 mm, base 4 mm, plugs 4 mm, gap 1 mm, 3 mm above the
    channel: outside 23 x 14 x 21 less the gap 1 x 14 x 12; air 2 x 6 x 12 x 16 and a channel
    3 x 4 x 2."""
    volumes = pneunet(chambers=2, symmetry=False).volumes()
    air = 2 * 6 * 12 * 16 + 3 * 4 * 2
    assert volumes["cavity"] == pytest.approx(air, rel=1e-12)
    assert volumes["body"] == pytest.approx(23 * 14 * 21 - 1 * 14 * 12 - air, rel=1e-12)
    assert volumes["strain_limiting_layer"] == pytest.approx(23 * 14, rel=1e-12)


def test_half_is_half_of_the_whole(meshed):
    half, whole = (meshed(pneunet(chambers=3, symmetry=s)) for s in (True, False))
    assert 2 * half.volumes.sum() == pytest.approx(whole.volumes.sum(), rel=1e-12)
    assert whole.layout.copies == 1 and half.layout.copies == 2
    # The whole is the half and its mirror image, cell by cell.
    positive = whole.points[whole.cells].mean(axis=1)[:, 1] > 0
    centres = [solid.points[solid.cells].mean(axis=1) for solid in (half, whole)]
    upper = centres[1][positive]
    lower = centres[1][~positive] * [1, -1, 1]
    ordered = [np.array(sorted(np.round(c, 6).tolist())) for c in (centres[0], upper, lower)]
    assert np.allclose(ordered[0], ordered[1]) and np.allclose(ordered[0], ordered[2])


def test_cavity_is_one_air_space(meshed):
    """The channel joins the chambers: the cavity's walls hang together."""
    solid = meshed(pneunet(chambers=4))
    triangles = solid.surfaces["cavity"]
    root = {int(p): int(p) for p in np.unique(triangles)}

    def find(p):
        while root[p] != p:
            root[p] = root[root[p]]
            p = root[p]
        return p

    for a, b, c in triangles.tolist():
        root[find(a)] = find(b)
        root[find(b)] = find(c)
    assert len({find(p) for p in root}) == 1


def test_walls_are_as_thick_as_asked():
    """Rays through the grid of a PneuNet with all walls different."""
    given = dict(
        chambers=2, chamber_length=5.0, gap=0.7, inner_wall=1.1, outer_wall=1.3, roof=1.7,
        base=2.3, channel_height=2.9, channel_roof=1.9, clamp_plug=3.1, tip_plug=4.3,
        symmetry=False,
    )  # fmt: skip
    mesh = pneunet(**given).solid().mesh(10.0, 10.0)
    middles = [(line[1:] + line[:-1]) / 2 for line in mesh.lines]

    def runs(axis, **at):
        """Lengths of the stretches of equal label along an axis through a point."""
        place = [int(np.argmin(abs(middles["xyz".index(k)] - at.get(k, 0)))) for k in "xyz"]
        place[axis] = slice(None)
        labels, edges = mesh.label[tuple(place)], mesh.lines[axis]
        ends = np.flatnonzero(np.diff(labels)) + 1
        return np.diff(edges[[0, *ends, len(labels)]])

    assert runs(0, y=0, z=15) == pytest.approx([3.1, 5, 1.1, 0.7, 1.1, 5, 4.3])
    assert runs(0, y=0, z=3) == pytest.approx([3.1, 5 + 1.1 + 0.7 + 1.1 + 5, 4.3])
    assert runs(1, x=5, z=15) == pytest.approx([1.3, 12, 1.3])
    assert runs(2, x=5, y=0) == pytest.approx([2.3, 16, 1.7])
    gap = 3.1 + 5 + 1.1 + 0.35
    assert runs(2, x=gap, y=0) == pytest.approx([2.3, 2.9, 1.9, 16 + 1.7 - 2.9 - 1.9])


@pytest.mark.parametrize(
    "given",
    [
        {"chamber_length": 7.0, "gap": 1.5},
        {"chamber_length": 7.0, "pitch": 10.5},
        {"chamber_length": 7.0, "length": 46.5},
        {"gap": 1.5, "pitch": 10.5},
        {"gap": 1.5, "length": 46.5},
        {"pitch": 10.5, "length": 46.5},
        {"chamber_length": 7.0, "gap": 1.5, "pitch": 10.5, "length": 46.5},
    ],
    ids=lambda given: "-".join(given),
)
def test_any_two_lengths_give_the_others(given):
    """Pitch 7 + 2 x 1 + 1.5; length of four chambers 4 + 7 + 3 x 10.5 + 4."""
    row = pneunet(chambers=4, **given).row
    assert (row.chamber_length, row.gap) == pytest.approx((7.0, 1.5))
    assert (row.pitch, row.length) == pytest.approx((10.5, 46.5))


@pytest.mark.parametrize("given", [{"pitch": 9.5}, {"length": 43.0}, {"chamber_length": 6.5}])
def test_one_length_goes_with_a_gap_of_1_mm(given):
    row = pneunet(chambers=4, **given).row
    assert (row.chamber_length, row.gap, row.pitch) == pytest.approx((6.5, 1.0, 9.5))


def test_contradicting_lengths_are_refused():
    found = faults(chambers=4, chamber_length=7.0, gap=1.5, length=50.0)
    assert list(found) == ["length"]
    assert "50 mm contradicts" in found["length"] and "46.5 mm" in found["length"]


@pytest.mark.parametrize(
    ("given", "field", "reason"),
    [
        ({"channel_height": 20.0}, "channel_height", "20 mm is taller than the chamber (16 mm)"),
        ({"channel_width": 15.0}, "channel_width", "outer walls would vanish"),
        ({"channel_roof": 15.0}, "channel_roof", "the gaps would vanish"),
        ({"layer_height": 4.0}, "layer_height", "base above the layer would vanish"),
        ({"length": 28.0}, "length", "the chambers would vanish"),
        ({"pitch": 3.0}, "pitch", "the chambers would vanish"),
        ({"pitch": 7.0, "chamber_length": 6.0}, "pitch", "the gap would vanish"),
        ({"length": 56.0, "chamber_length": 6.0}, "length", "the gap would vanish"),
        *[
            ({name: 0.0}, name, f"the {name.replace('_', ' ')} would vanish")
            for name in ("roof", "base", "outer_wall", "inner_wall", "channel_roof", "gap",
                         "tip_plug", "clamp_plug", "chamber_width", "mesh_size")
        ],
        ({"roof": -1.0}, "roof", "the roof would vanish"),
        ({"length": 1e300}, "length", "longer than any actuator"),
        ({"mesh_size": 0.01}, "mesh_size", "tetrahedra"),
        ({"cavity_mesh_size": 0.01}, "cavity_mesh_size", "tetrahedra"),
        ({"chambers": 0}, "chambers", "greater than or equal to 1"),
    ],
)  # fmt: skip
def test_impossible_parameters_are_refused_with_the_wall(given, field, reason):
    found = faults(**given)
    assert list(found) == [field]
    assert reason in found[field]


def test_all_faults_at_once():
    found = faults(channel_height=20.0, layer_height=5.0, channel_width=40.0)
    assert sorted(found) == ["channel_height", "channel_width", "layer_height"]


def test_cavity_mesh_size_refines_the_chambers():
    coarse, fine = (pneunet(chambers=2, **g) for g in ({}, {"cavity_mesh_size": 1.0}))
    cells = [
        len(g.solid().mesh(2.0, g.cavity_mesh_size or 2.0).tetrahedra(0)) for g in (coarse, fine)
    ]
    assert cells[1] > 2 * cells[0]


def test_default_sizes():
    """The mesh sizes that the README and the design speak of."""
    counts = {}
    for given in ({"chambers": 8}, {"chambers": 14, "length": 146.0}):
        counts[given["chambers"]] = len(pneunet(**given).solid().mesh(2.0, 2.0).tetrahedra(0))
    assert 8_000 < counts[8] < 13_000 and 15_000 < counts[14] < 30_000


def test_unequal_chambers_counted_by_hand(meshed):
    """Air 12 mm wide: 5 x 16 + 6 x 12 + 7 x 14 + 8 x 10 mm, and a channel 4 x 2 mm through walls
    and gaps, 3.2 + 7.1 + 4 mm. Side: blocks of 10, 8.4, 8.8 and 13.1 mm, 21, 17.5, 19.2 and 16 mm
    tall, and bridges of 8 mm, 9 mm tall."""
    solid = meshed(pneunet(**UNEVEN, symmetry=False))
    air = 12 * (5 * 16 + 6 * 12 + 7 * 14 + 8 * 10) + 4 * 2 * (3.2 + 7.1 + 4.0)
    side = 10 * 21 + 8.4 * 17.5 + 8.8 * 19.2 + 13.1 * 16 + 8 * 9
    assert solid.geometry.volumes()["cavity"] == pytest.approx(air, rel=1e-12)
    assert solid.geometry.volumes()["body"] == pytest.approx(14 * side - air, rel=1e-12)
    assert abs(solid.volumes).sum() == pytest.approx(14 * side - air, rel=1e-9)
    assert min(abs(solid.volumes)) > 0 and len(set(np.sign(solid.volumes))) == 1


def test_equal_lists_are_the_finger_without_them(meshed):
    even = meshed(pneunet(chambers=3, chamber_length=6.0, gap=1.0))
    lists = {
        "chamber_lengths": ["6 mm"] * 3,
        "chamber_heights": ["16 mm"] * 3,
        "roofs": ["1 mm"] * 3,
    }
    lists |= {"inner_walls": ["1 mm"] * 3, "gaps": ["1 mm"] * 2}
    listed = meshed(pneunet(chambers=3, **lists))
    assert np.allclose(even.points, listed.points, atol=1e-12)
    assert np.array_equal(even.cells, listed.cells)


def test_cad_of_unequal_chambers_has_their_volume():
    import gmsh

    geometry = pneunet(**UNEVEN)
    gmsh.initialize()
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        geometry.build(gmsh)
        solids = gmsh.model.getEntities(3)
        volume = sum(gmsh.model.occ.getMass(*solid) for solid in solids)
    finally:
        gmsh.finalize()
    assert volume == pytest.approx(geometry.volumes()["body"], rel=1e-9)


@pytest.mark.parametrize(
    ("changes", "where", "why"),
    [
        ({"chamber_lengths": ["5 mm", "6 mm"]}, "chamber_lengths", "2 lengths, but 4 are wanted"),
        ({"gaps": ["1 mm"] * 4}, "gaps", "4 lengths, but 3 are wanted, for the gaps between"),
        ({"length": "60 mm"}, "length", "follows from chamber_lengths"),
        ({"chamber_heights": ["5 mm"] * 4}, "chamber_heights", "no taller than the channel"),
        ({"roofs": ["1 mm", "1 mm", "1 mm", "0 mm"]}, "roofs", "would vanish"),
    ],
)
def test_lists_that_do_not_fit_are_told_in_a_line(changes, where, why):
    found = faults(**(UNEVEN | changes))
    assert list(found) == [where]
    assert why in found[where]
