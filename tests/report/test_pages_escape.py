"""A name with <, & and quotes, wherever it comes from, is a text on each page: escaped, and
once."""

import re
from html.parser import HTMLParser

import numpy as np
import pytest

from softact.converge import output as convergence
from softact.converge.carry import carry_into
from softact.fit.modes import nominal_stress
from softact.fit.run import Request
from softact.fit.run import run as fit
from softact.fit.sheet import make_sheet
from softact.measured.curve import Measured
from softact.optimise import optimise_page
from softact.optimise.spec import Optimisation
from softact.optimise.study import Trials
from softact.report import overlay, pictures, write_report
from softact.report.base import Section, banner, card, download, frame, note, page, table
from softact.report.compare import write_comparison
from softact.results.own_folder import Output
from softact.results.writer import ResultsWriter
from softact.sweep import compute as computing
from softact.sweep import output as sweeping
from softact.sweep.cache import Cache
from softact.sweep.spec import Sweep, read
from softact.sweep.study import locally, open_study
from tests import bent_beam
from tests.report.test_pages_browser import a_study
from tests.report.test_study_pages_browser import LAW, STRETCH
from tests.sweep.folders import CUBE, instead_of_run

NAME = "a<i> & \"c\" 'd'"
YAML = "'" + NAME.replace("'", "''") + "'"
CAVITY, STEP, FILE = f"cavity {NAME}", f"step {NAME}", f"file {NAME}.csv"
TOLD = f"name: told\ndescription: {YAML}\nsource: {YAML}\n"


class Reader(HTMLParser):
    """What a reader may see of a page: the tags, and the texts between and in them."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.tags, self.texts = set(), []
        self.feed(re.sub(r"<(script|style)\b.*?</\1>", "", page, flags=re.S))

    def handle_starttag(self, tag, attributes):
        self.tags.add(tag)
        self.texts += [value for _, value in attributes if value]

    def handle_data(self, data):
        self.texts.append(data)

    def sees(self, text: str) -> bool:
        return any(text in seen for seen in self.texts)


def a_run(folder):
    """A result folder with the name in the spec, a step, a cavity, the notes and the versions."""
    spec = f"name: {YAML}\ndescription: {YAML}\nsource: {YAML}\nassumptions: [{YAML}]\n"
    writer = ResultsWriter(folder, spec, {})
    for part in (0.5, 1.0):
        row = {"step": STEP, "step_fraction": part, f"cavity_volume_{CAVITY}_mm3": part}
        writer.increment(row | {f"pressure_{CAVITY}_kPa": 2 * part})
    history = [{"step": STEP, "fraction": 1.0, "iterations": 1, "converged": True}]
    writer.finish("complete", {}, {"notes": [NAME], "history": history, "versions": {NAME: NAME}})
    return folder


def reports(top):
    x, y = f"pressure_{CAVITY}_kPa", f"cavity_volume_{CAVITY}_mm3"
    measured = Measured(FILE, x, {x: np.array([1.0, 2.0]), y: np.array([0.4, 0.9])})
    folder, other = a_run(top / f"one {NAME}"), a_run(top / f"two {NAME}")
    return {
        "report": write_report(folder, [lambda run: overlay.section(run, [measured])]),
        "comparison": write_comparison([folder, other], top / "compare"),
    }


def a_report_of_a_mesh_study(top):
    """Its study's meshes are called by the name, and the converge page's title, too."""
    study, folder = a_study(top), top / "level0"
    carry_into(study, folder)
    told = folder / "mesh_error.json"
    told.write_text(told.read_text().replace("mesh_size 4 mm", NAME.replace('"', r"\"")))
    path = convergence.write(study, NAME, Output(top, "converge"))
    return {"mesh error": write_report(folder), "convergence": path}


def studies(top):
    (top / "sweep.yaml").write_text(
        f"{TOLD}{CUBE}axes: [{{path: geometry.length, values: [4 mm, 6 mm]}}]\n"
        "trends: [{measure: bending_angle_deg, axis: geometry.length, does: rise, "
        f"source: {YAML}}}]\n"
    )
    study = open_study(*read(top / "sweep.yaml", Sweep), Cache(top / "runs"))
    study.compute(locally(1), lambda point, answer: None)
    sweeping.write(study, None, Output(top, "sweep"))
    (top / "opt.yaml").write_text(
        f"{TOLD}{CUBE}parameters: [{{path: geometry.length, from: 4 mm, to: 20 mm}}]\n"
        "objectives: [{measure: bending_angle_deg, goal: maximise}]\ntrials: 2\n"
    )
    trials = Trials(*read(top / "opt.yaml", Optimisation), Cache(top / "runs"), top)
    trials.run(1, lambda trial, answer: None)
    path = optimise_page.write(trials, Output(top, "optimize"))
    return {"sweep": top / "sweep.html", "optimisation": path}


def a_fit(top):
    stress = 1e3 * nominal_stress(LAW, LAW, "uniaxial", STRETCH)
    rows = [f"{s:.8f};{p:.8f}" for s, p in zip(STRETCH, stress, strict=True)]
    (top / FILE).write_text("\n".join(["stretch;nominal stress (kPa)", *rows]))
    sheet = make_sheet({"file": top / FILE, "mode": "uniaxial"}, "x")
    fit(Request([sheet], "yeoh", top / "fit", "mine"), lambda line: None)
    return {"fit": top / "fit" / "mine.html"}


@pytest.fixture(scope="module")
def pages(tmp_path_factory):
    """Name -> text of a page of each kind."""
    top = tmp_path_factory.mktemp("names")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(pictures, "drawing", bent_beam.undrawn)
        patch.setattr(computing, "run", instead_of_run)
        patch.setattr(optimise_page, "write_report", lambda directory: None)
        made = reports(top) | a_report_of_a_mesh_study(top) | studies(top) | a_fit(top)
    return {kind: path.read_text(encoding="utf-8") for kind, path in made.items()}


@pytest.mark.parametrize(
    "kind, names",
    [
        ("report", [NAME, STEP, f"Cavity volume {CAVITY}", FILE]),
        ("comparison", [f"one {NAME}", f"two {NAME}", f"Cavity volume {CAVITY}"]),
        ("mesh error", [NAME]),
        ("convergence", [NAME]),
        ("sweep", [NAME, f"Source: {NAME}"]),
        ("optimisation", [NAME, f"Source: {NAME}"]),
        ("fit", [FILE.removesuffix(".csv")]),
    ],
)
def test_a_name_is_a_text_on_each_page(pages, kind, names):
    text, reader = pages[kind], Reader(pages[kind])
    assert [name for name in names if not reader.sees(name)] == []
    assert "i" not in reader.tags and "<i>" not in text
    assert re.findall(r"&amp;(?:lt|gt|amp|quot|#\d+|#x27);", text) == []


def test_every_piece_escapes_texts_and_keeps_pieces():
    inner = note(NAME)
    pieces = [
        banner("good", NAME, NAME, [NAME, (NAME, NAME)]),
        card(NAME, NAME, NAME, NAME, NAME),
        download(f"{NAME}.csv", b"", text=NAME),
        frame(NAME, NAME),
        table([NAME], [[NAME]], file=f"{NAME}.csv"),
        banner("good", "", inner),
    ]
    sections = [Section("x", NAME, piece) for piece in pieces] + [Section("y", "y", NAME)]
    text = page(NAME, sections, kicker=NAME, kind=NAME, lead=NAME)
    assert "<i>" not in text and "&amp;lt;" not in text
    assert text.count(str(inner)) == 1
    assert Reader(text).texts.count(NAME) >= 20
