"""The colour of a run and its reasons, from what stands in its folder."""

import json

import numpy as np
import pytest

from softact.report import write_report
from softact.results.folder import MESH_ERROR, read
from softact.results.writer import ResultsWriter
from softact.verdict.judge import AMBER, GREEN, RED, from_data, judge
from tests import bent_beam

SIZE = {"nx": 12, "ny": 2, "nz": 7}


def write(folder, changes=(), angle=90.0, status="complete", stretches=None, spec=None, **told):
    """The bent beam in as many states as there are changes (dicts) of its rows, and two more before
    them; its pressure goes up by 10 kPa from one to the next. stretches: of nodes, by state."""
    points, cells, surfaces = bent_beam.mesh(**SIZE)
    writer = ResultsWriter(folder, spec or bent_beam.SPEC, {"spec_hash": "0f3a"})
    writer.mesh(points, cells, np.zeros(len(cells)), ["body"], surfaces, bent_beam.LAYOUT)
    rows = [{}, {}, *changes]
    for number, change in enumerate(rows):
        part = number / max(len(rows) - 1, 1)
        fields = bent_beam.state(points, angle * part)
        if stretches is not None:
            fields["max_principal_stretch"] = stretches(points, number)
        row = bent_beam.row(points, fields, part, angle * part) | {"pressure_kPa": 10.0 * number}
        row |= {"unstable_modes": 0, "control": "load", "kinetic_ratio": 0.0}
        writer.increment(row | change, fields)
    if status:
        writer.finish(status, {}, told)
    return judge(read(folder))


def kinds(verdict):
    return [reason.kind for reason in verdict.reasons]


def test_a_run_without_a_remark_is_green(tmp_path):
    verdict = write(tmp_path / "r", [{}])
    assert (verdict.colour, verdict.reasons) == (GREEN, ())
    assert verdict.lines == ["solved and trusted"]


def test_what_the_solver_remarks_makes_it_amber(tmp_path):
    verdict = write(tmp_path / "r", [{}], messages=["step 'inflate': snaps at 15 kPa"])
    assert verdict.colour == AMBER
    assert verdict.lines == ["solved, but:", "  - step 'inflate': snaps at 15 kPa"]


@pytest.mark.parametrize(
    "status, messages, said",
    [("no_equilibrium", ["no equilibrium found beyond 40 %"], "no equilibrium found beyond 40 %"),
     ("no_equilibrium", [], "no further equilibrium was found"),
     (None, [], "the run has not ended, or was stopped")],
)  # fmt: skip
def test_a_run_that_is_not_at_its_end_is_red(tmp_path, status, messages, said):
    verdict = write(tmp_path / "r", [{}], status=status, messages=messages)
    assert verdict.colour == RED
    assert verdict.lines[0] == "not solved:" and said in verdict.lines[1]


def test_a_folder_without_a_state_is_red(tmp_path):
    ResultsWriter(tmp_path / "r", "name: r\n", {}).finish("no_equilibrium", {}, {"messages": ["x"]})
    assert judge(read(tmp_path / "r")).lines == ["not solved:", "  - x"]


def test_elements_that_are_folded_at_a_corner_are_told(tmp_path):
    """Below zero from 30 kPa on, most so at 40 kPa, where its place is told."""
    smallest = [0.2, -0.1, -0.31, -0.2]
    changes = [
        {"jacobian_min": j, **{f"jacobian_min_{c}_mm": 4.0 * j for c in "xyz"}} for j in smallest
    ]
    assert write(tmp_path / "sound", changes[:1]).colour == GREEN
    verdict = write(tmp_path / "r", changes)
    assert (verdict.colour, kinds(verdict)) == (AMBER, ["folded"])
    assert verdict.lines[1] == (
        "  - elements are folded at a corner near x, y, z = -1.2, -1.2, -1.2 mm of the undeformed "
        "actuator (J = det F is -0.31 there at 40 kPa, and at or below 0 from 30 kPa on): refine "
        "the mesh there"
    )


MOVED = {"control": "motion", "kinetic_ratio": 0.01}


@pytest.mark.parametrize(
    "changes, said",
    [([{}, MOVED], "the last state is one of a motion and no equilibrium"),
     ([MOVED, {}], "the states up to 20 kPa are of a slow motion and no equilibria"),
     # The beginning of a long way: 20 of 300 kPa.
     ([MOVED, {"pressure_kPa": 300.0}], None)],
)  # fmt: skip
def test_a_motion_is_no_equilibrium(tmp_path, changes, said):
    verdict = write(tmp_path / "r", changes)
    assert kinds(verdict) == ([] if said is None else ["motion"])
    assert said is None or said in verdict.reasons[0].text


@pytest.mark.parametrize("ratio, told", [(0.04, False), (0.2, True)])
def test_a_jump_with_much_kinetic_energy(tmp_path, ratio, told):
    verdict = write(tmp_path / "r", [{"control": "dynamics", "kinetic_ratio": ratio}, {}])
    assert kinds(verdict) == (["kinetic"] if told else [])
    assert not told or "on the way to 20 kPa the kinetic energy was up to 20 %" in verdict.lines[1]


@pytest.mark.parametrize("share, told", [(0.9, False), (3.5, True)])
def test_volume_that_is_not_kept(tmp_path, share, told):
    change = {
        "volume_change_beyond_percent": share, "volume_change_p99": 0.31, "volume_change_max": 2.89,
        **{f"volume_change_max_{c}_mm": 1.5 for c in "xyz"},
    }  # fmt: skip
    verdict = write(tmp_path / "r", [change])
    assert kinds(verdict) == (["volume"] if told else [])
    if told:
        said = verdict.reasons[0].text
        assert "at 20 kPa, 3.5 % of it changes by more than 20 %" in said
        assert "1 % of it by more than 31 %" in said and "single points up to 289 %" in said
        assert "1.5, 1.5, 1.5 mm" in said


def test_a_law_that_does_not_keep_the_volume_at_large_stretch(tmp_path, monkeypatch):
    """Ecoflex of Agarwal: K = 2/d1 = 0.684 MPa, 24.7 times its shear modulus of 27.7 kPa. The layer
    of paper does not claim to keep its volume."""
    materials = "materials: {body: {card: ecoflex-00-30}, tab: {card: paper}}"
    monkeypatch.setattr(bent_beam, "SPEC", bent_beam.SPEC + materials)
    change = {"volume_change_beyond_percent": 97.0, "volume_change_p99": 1.31}
    (reason,) = write(tmp_path / "r", [change]).reasons
    assert reason.text.endswith(
        "; bulk_modulus: 27.7 MPa in materials.body (K is 24.7 times the shear modulus now) keeps "
        "it"
    )


@pytest.mark.parametrize(
    "found, bars, spec_hash, said",
    [("within", {"bending_angle_deg": 4.0}, "0f3a", ""),
     ("not converged", {"bending_angle_deg": 9.0}, "0f3a",
      "the mesh has not converged within 5 %: bending_angle_deg (known to 10 %)"),
     ("not converged", {}, "0f3a", "the mesh has not converged within 5 %: bending_angle_deg;"),
     ("not known", {}, "0f3a", "its limit is not known: bending_angle_deg"),
     ("not converged", {"bending_angle_deg": 9.0}, "else", "")],
)  # fmt: skip
def test_a_mesh_that_is_not_converged(tmp_path, found, bars, spec_hash, said):
    """It is trusted only where the study says so, also where it gives no error bar; what it says of
    another spec does not count."""
    write(tmp_path / "r", [{}])
    story = {
        "error_bars": bars, "level": 0, "tolerance": 0.05, "verdict": found,
        "measures": {"bending_angle_deg": {"verdict": found}}, "levels": [{"spec_hash": spec_hash}],
    }  # fmt: skip
    (tmp_path / "r" / MESH_ERROR).write_text(json.dumps(story))
    verdict = judge(read(tmp_path / "r"))
    assert (verdict.colour, kinds(verdict)) == ((AMBER, ["mesh"]) if said else (GREEN, []))
    assert not said or said in verdict.lines[1]


def test_a_body_that_passes_through_itself(tmp_path):
    verdict = write(tmp_path / "r", [{}, {}, {}], angle=400.0)
    assert (verdict.colour, kinds(verdict)) == (AMBER, ["overlap"])
    said = verdict.reasons[0].text
    assert "passes through itself at 40 kPa" in said and "'clamp'" in said and "'tip'" in said
    assert "contact: auto in the spec keeps" in said


@pytest.mark.parametrize(
    "contact, said",
    [
        ("none", "contact: auto in the spec keeps"),
        ("auto", "a smaller mesh_size sees them sooner"),
        ("[{self: [clamp, tip, base, top]}]", "a smaller mesh_size sees them sooner"),
        ("[{self: clamp}]", "under contact in the spec keeps"),
        ("[{between: [clamp, tip]}]", "under contact in the spec keeps"),
    ],
)
def test_what_keeps_it_apart_is_not_what_is_there(tmp_path, contact, said):
    spec = f"{bent_beam.SPEC}\ncontact: {contact}\n"
    verdict = write(tmp_path / "r", [{}, {}, {}], angle=400.0, spec=spec)
    assert said in verdict.reasons[0].text


def test_where_a_body_passes_through_itself_is_told_once(tmp_path, monkeypatch):
    """The report of a run that has just been judged takes its verdict with the places; that of
    run.json has none, and is sought again."""
    verdict = write(tmp_path / "r", [{}, {}, {}], angle=400.0)
    told = from_data(json.loads(json.dumps(verdict.data(places=True))))
    stored = from_data(json.loads(json.dumps(verdict.data())))
    assert told == stored == verdict  # in words
    assert (told.reasons[0].place, told.reasons[0].row) == (verdict.reasons[0].place, 4)
    assert told.has_places and not stored.has_places

    looked = []
    monkeypatch.setattr(
        "softact.verdict.judge.judge", lambda results: looked.append(results) or judge(results)
    )
    pictures = []
    for given in (told, stored):
        write_report(tmp_path / "r", verdict=given)
        pictures.append((tmp_path / "r" / "shape.png").read_bytes())
    assert len(looked) == 1 and pictures[0] == pictures[1]


def test_fields_that_cannot_be_read_are_not_trusted(tmp_path):
    write(tmp_path / "r", [{}])
    (tmp_path / "r" / "fields.h5").write_bytes(b"torn")
    verdict = judge(read(tmp_path / "r"))
    assert (verdict.colour, kinds(verdict)) == (AMBER, ["unread"])


BALLOON = np.array([60.0, 0.0, bent_beam.HEIGHT])


def ballooning(points, number):
    """Stretches to 1.5 everywhere at the limit, and to 3.5 near the middle of the roof after it."""
    near = np.linalg.norm(points - BALLOON, axis=1) < 14
    return 1 + 0.25 * min(number, 2) + 2.0 * near * (number - 2) / 2 * (number > 2)


def test_which_wall_balloons_is_told(tmp_path):
    """Over the limit at 20 kPa the pressure falls, the cavity grows, and the roof is stretched in
    the middle of the length."""
    beyond = [
        {"unstable_modes": 1, "pressure_kPa": 18.0, "control": "volume", "cavity_volume_mm3": 2e4},
        {"unstable_modes": 1, "pressure_kPa": 15.0, "control": "volume", "cavity_volume_mm3": 3e4},
    ]
    verdict = write(
        tmp_path / "r", [{}, *beyond], status="no_equilibrium", stretches=ballooning,
        messages=["pressure cannot exceed 20 kPa"],
    )  # fmt: skip
    assert kinds(verdict) == ["end", "limit"]
    said = verdict.reasons[1].text
    assert said.startswith("the upper wall ") and "from the clamp" in said
    along = float(said.split(" mm from the clamp")[0].split()[-1])
    assert along == pytest.approx(60, abs=14)
    assert "from 1.50 to 3.50" in said and "the pressure falls to 15 kPa" in said
    assert "thicker" in said and "inject" in said


def test_what_snaps_without_a_balloon_is_told(tmp_path):
    beyond = [{"unstable_modes": 1, "pressure_kPa": 18.0, "control": "volume"}]
    verdict = write(
        tmp_path / "r", [{}, *beyond, {}], messages=["snaps"],
        stretches=lambda points, number: np.full(len(points), 1.1),
    )  # fmt: skip
    assert kinds(verdict) == ["limit", "remark"]
    assert "moves most there" in verdict.reasons[0].text


def test_it_comes_back_from_run_json(tmp_path):
    verdict = write(tmp_path / "r", [{}], messages=["snaps at 15 kPa"])
    assert from_data(json.loads(json.dumps(verdict.data()))) == verdict
    for nonsense in (None, {}, {"colour": "blue", "reasons": []}, {"colour": RED, "reasons": 3}):
        assert from_data(nonsense) is None
