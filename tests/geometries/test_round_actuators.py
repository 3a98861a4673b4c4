"""What is special about the round actuators: where cavities lie, what is refused."""

import numpy as np
import pytest
from pydantic import ValidationError

from softact.geometries import GEOMETRIES


def make(geometry, **given):
    """A geometry from lengths in mm (and whole numbers, truths and texts)."""
    return GEOMETRIES[geometry].model_validate(
        {k: f"{v} mm" if isinstance(v, float) else v for k, v in given.items()}
    )


def centre(solid, name):
    middles, areas = solid.outward_areas(name)
    weight = np.linalg.norm(areas, axis=1)
    return (weight[:, None] * middles).sum(axis=0) / weight.sum()


@pytest.mark.parametrize(("cavities", "on_top"), [(3, "cavity"), (4, "wall")])
def test_cavities_follow_each_other_around_the_axis(cavities, on_top, meshed):
    """The middle of cavity k lies at 90° − 360° k/n, half a cavity further on under a wall."""
    solid = meshed(make("omnidirectional", cavities=cavities, on_top=on_top, modules=2, gap=2.0))
    for number in range(cavities):
        _, y, z = centre(solid, f"cavity_{number + 1}")
        turns = (number + (on_top == "wall") / 2) / cavities
        wanted = np.array([np.sin(2 * np.pi * turns), np.cos(2 * np.pi * turns)])
        assert np.array([y, z]) / np.hypot(y, z) == pytest.approx(wanted, abs=0.02)


def test_without_channels_every_chamber_is_a_room_of_its_own():
    """Area of a third of a disc of 10.5 mm less half a wall of 1 mm on both sides, by Monte Carlo
    on a fine grid; 5 mm long, two modules."""
    bellows = make("omnidirectional", channels=False, modules=2)
    y, z = np.meshgrid(*[np.linspace(-11, 11, 2201)] * 2, indexing="ij")
    inside = np.hypot(y, z) < 10.5
    for turn in (-1, 1):  # beyond both walls, whose normals are at 60° from the middle
        angle = np.pi / 2 + turn * np.pi / 3
        normal = -turn * np.array([-np.sin(angle), np.cos(angle)])
        inside &= y * normal[0] + z * normal[1] > 0.5
    area = inside.sum() * 0.01**2
    assert bellows.volumes()["cavity_1"] == pytest.approx(2 * 5 * area, rel=1e-3)


def test_segments_have_cavities_of_their_own(meshed):
    """Two segments of two modules with channels: a channel of each cavity joins the two chambers of
    a segment, none those at the gap between the segments, whose place is solid. By hand: what a
    single segment of four modules has more is that channel, once for each of three cavities."""
    arm = make("omnidirectional", modules=2, segments=2)
    single = make("omnidirectional", modules=4)
    channel = single.volumes()["cavity_1"] - 2 * arm.volumes()["segment_1_cavity_1"]
    angle = np.pi / 3 - np.arcsin(0.5 / 3.5)
    sector = 3.5**2 * angle - 0.5 / np.sin(np.pi / 3) * 3.5 * np.sin(angle)
    assert channel == pytest.approx(5.0 * sector, rel=1e-9)
    assert arm.volumes()["body"] - single.volumes()["body"] == pytest.approx(3 * channel, rel=1e-9)
    solid = meshed(arm)
    for segment, (start, end) in {1: (2.5, 17.5), 2: (22.5, 37.5)}.items():
        for number in range(1, 4):
            middles, _ = solid.outward_areas(f"segment_{segment}_cavity_{number}")
            assert start - 1e-9 <= middles[:, 0].min() and middles[:, 0].max() <= end + 1e-9
    assert arm.length == 40.0 and len(solid.layout.cavities) == 6


def test_one_segment_keeps_its_names():
    assert tuple(make("omnidirectional", segments=1).layout().cavities) == (
        "cavity_1", "cavity_2", "cavity_3",
    )  # fmt: skip


def test_pairs_are_turned_by_a_right_angle(meshed):
    solid = meshed(make("antagonistic", chambers=2))
    middles = {name: centre(solid, name) for name in solid.layout.cavities}
    half = solid.layout.length / 2
    for name, (axis, sign) in {
        "upper_a": (2, 1), "upper_b": (2, -1), "lower_a": (1, 1), "lower_b": (1, -1),
    }.items():  # fmt: skip
        across = middles[name] * [0, 1, 1]
        assert abs(across[axis]) > 5 * abs(across[3 - axis]) and sign * across[axis] > 3
        assert (middles[name][0] < half) == name.startswith("upper")


def test_assumed_walls_of_the_antagonist_use_the_printed_resin():
    """The paper printed 97.65 mL, supports included."""
    assert 95e3 < make("antagonistic").volumes()["body"] < 97.65e3


def test_every_cut_takes_its_slit_from_the_shell(meshed):
    """Bending: 2 mm of the circumference but for a strip, which is 3 mm seen from below."""
    shell = [make("shell_reinforced", cuts=n, symmetry=False).volumes()["shell"] for n in (4, 5)]
    strip = 2 * np.arcsin(1.5 / 11) * 11
    assert shell[0] - shell[1] == pytest.approx(2 * (2 * np.pi * 11 - strip), rel=1e-12)


@pytest.mark.parametrize("kind", ["bending", "linear"])
def test_the_pattern_of_the_shell(kind):
    """Its cuts are the outline of the unrolled shell and of its slits: area of the slits from the
    closed form, and lines that end on each other."""
    actuator = make("shell_reinforced", kind=kind, cuts=5, symmetry=False)
    lines = np.array(actuator.pattern().cut)
    assert lines[..., 0].min() == 0 and lines[..., 0].max() == 80
    around = 2 * np.pi * 11
    assert np.ptp(lines[..., 1]) == pytest.approx(around)
    ends = np.round(lines.reshape(-1, 2), 6)
    _, counts = np.unique(ends, axis=0, return_counts=True)
    assert (counts % 2 == 0).all()
    across = lines[(lines[:, 0, 0] == lines[:, 1, 0]) & ~np.isin(lines[:, 0, 0], [0, 80])]
    slits = np.abs(np.diff(across[..., 1], axis=1)).sum() / 2 * actuator.slit
    assert around * 80 - slits == pytest.approx(actuator.volumes()["shell"])


@pytest.mark.parametrize(
    ("kind", "glue"), [("bending", None), ("bending", "strip and ends"), ("linear", None)]
)
def test_a_sliding_shell_is_the_bonded_one_in_two_parts(kind, glue, meshed):
    """And both lie on the core's outside; what is glued has the closed form's area."""
    given = {"kind": kind, "cuts": 2, "mesh_size": 6.0}
    shell = make("shell_reinforced", **given).volumes()["shell"]
    sliding = make("shell_reinforced", shell="sliding", glue=glue, **given)
    assert sliding.volumes()["under_shell"] + sliding.volumes()["under_glued"] == pytest.approx(
        shell
    )
    solid = meshed(sliding)
    for name in sliding.layout().covers.values():
        middles, areas = solid.outward_areas(name)
        assert (np.linalg.norm(middles[:, 1:], axis=1) > 10).all()
        assert (np.einsum("ij,ij->i", areas[:, 1:], middles[:, 1:]) > 0).all()


def test_linear_slits_alternate(meshed):
    """In the first row the shell is left on the sides, in the second above and below."""
    actuator = make("shell_reinforced", kind="linear", cuts=2, symmetry=False)
    solid = meshed(actuator)
    middles, _ = solid.outward_areas("shell")
    for row, ((start, end), axis) in enumerate(zip(actuator._slits(), (1, 2), strict=True)):
        here = middles[(middles[:, 0] > start) & (middles[:, 0] < end)]
        assert len(here) and (abs(here[:, axis]) > 10).all(), row
        assert (here[:, axis] > 0).any() and (here[:, axis] < 0).any()


def test_normals_of_the_sleeve_point_out_of_it(meshed):
    solid = meshed(make("fiber_reinforced", length=30.0))
    middles, areas = solid.outward_areas("outer")
    normal = solid.geometry.wall_normal("sleeve", middles)
    normal = normal / np.linalg.norm(normal, axis=1)[:, None]
    outward = areas / np.linalg.norm(areas, axis=1)[:, None]
    # The chords of a circle of 9 mm in pieces of 22.5° at most: cos 11.25° = 0.981.
    assert (np.einsum("ij,ij->i", normal, outward) > 0.98).all()


@pytest.mark.parametrize(
    ("kind", "given", "field", "reason"),
    [
        ("omnidirectional", {"gap": 8.0}, "pitch", "chambers would vanish"),
        (
            "omnidirectional",
            {"midsection_radius": 12.0, "channels": False},
            "midsection_radius",
            "gaps would vanish",
        ),
        (
            "omnidirectional",
            {"midsection_radius": 1.5},
            "midsection_radius",
            "channels in the gaps",
        ),
        ("omnidirectional", {"top_wall": 9.0}, "top_wall", "chambers would vanish"),
        ("omnidirectional", {"core_radius": 4.0}, "core_radius", "channels: false"),
        ("omnidirectional", {"cavities": 2}, "cavities", "greater than or equal to 3"),
        ("omnidirectional", {"segments": 0}, "segments", "greater than or equal to 1"),
        (
            "omnidirectional",
            {"segments": 2, "module_alone": True},
            "segments",
            "a module alone is of one segment",
        ),
        ("antagonistic", {"gap": 11.0}, "pitch", "chambers would vanish"),
        ("antagonistic", {"bore": 7.0}, "bore", "walls around the bores would vanish"),
        ("antagonistic", {"bore_distance": 17.0}, "bore_distance", "into the lower chambers"),
        ("antagonistic", {"midsection_radius": 4.0}, "midsection_radius", "would vanish"),
        ("shell_reinforced", {"chamber_radius": 11.0}, "chamber_radius", "wall would vanish"),
        ("shell_reinforced", {"cuts": 40}, "cuts", "rings of the shell would vanish"),
        ("shell_reinforced", {"end": 40.0}, "end", "chamber would vanish"),
        ("shell_reinforced", {"glue": "ends"}, "glue", "write shell: sliding"),
        (
            "shell_reinforced",
            {"shell": "sliding", "kind": "linear", "glue": "strip"},
            "glue",
            "write ends",
        ),
        ("fiber_reinforced", {"wall": 5.5}, "radius", "chamber would vanish"),
        ("fiber_reinforced", {"end": 80.0}, "end", "chamber would vanish"),
    ],
)
def test_impossible_parameters_are_refused(kind, given, field, reason):
    with pytest.raises(ValidationError) as caught:
        make(kind, **given)
    assert [(f["loc"][0]) for f in caught.value.errors()] == [field]
    assert reason in caught.value.errors()[0]["msg"]
