"""FMI 2.0 co-simulation, by pythonfmu: pressure and force on the tip in, angle, place and volume
out.

The unit carries ``rod.py`` and ``model.json`` and needs numpy in the Python of whoever runs it. It
is an equilibrium at each communication point; there is no inertia in it.
"""

from __future__ import annotations

import shutil
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path

from softact.errors import CannotWriteError, SpecError
from softact.export import rod, to_json
from softact.export.job import Job
from softact.export.statement import quoted
from softact.fields import STANDARD_GRAVITY
from softact.files.text import json_text

ROD = "reduced_rod.py"


def files(job: Job) -> dict[str, str | bytes]:
    """The unit. Raises SpecError where pythonfmu is not installed."""
    if find_spec("pythonfmu") is None:
        raise SpecError(
            "--to fmu: the package pythonfmu is not installed; pip install 'softact[export]'"
        )
    try:
        return {f"{job.name}.fmu": _built(job)}
    except OSError as error:
        raise CannotWriteError(
            f"no temporary files: {error.strerror or error}; export TMPDIR=DIR names a folder"
        ) from None


def _built(job: Job) -> bytes:
    from pythonfmu.builder import FmuBuilder

    # Not the name alone, which may be that of a module of Python's or one of its words.
    name = f"softact_{job.name}"
    with tempfile.TemporaryDirectory() as folder, _imports_undone():
        here = Path(folder)
        script, model = here / f"{name}.py", here / to_json.MODEL
        text = SLAVE.format(name=name, about=quoted(job.about), gravity=STANDARD_GRAVITY)
        script.write_text(text, encoding="utf-8")
        shutil.copyfile(rod.__file__, here / ROD)
        model.write_text(json_text(to_json.document(job)), encoding="utf-8")
        made = FmuBuilder.build_FMU(script, dest=here / "made", project_files=[here / ROD, model])
        return made.read_bytes()


@contextmanager
def _imports_undone() -> Iterator[None]:
    """The builder imports the script, and finds it by its folder: forget both afterwards."""
    known, path = set(sys.modules), list(sys.path)
    try:
        yield
    finally:
        sys.path[:] = path
        for name in set(sys.modules) - known:
            if not name.startswith("pythonfmu"):
                del sys.modules[name]


SLAVE = '''\
"""{about}"""

import json
import sys
from pathlib import Path

from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real

sys.path.insert(0, str(Path(__file__).parent))

import reduced_rod  # noqa: E402

GRAVITY = {gravity!r}  # mm/s² for each g


class {name}(Fmi2Slave):
    description = "A soft actuator: reduced model of constant curvature by softact"

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        path = Path(__file__).parent / "model.json"
        self._rod = reduced_rod.Rod(json.loads(path.read_text(encoding="utf-8")))
        self.pressure_kPa = 0.0
        for axis in "xyz":
            setattr(self, f"tip_force_{{axis}}_N", 0.0)
            setattr(self, f"gravity_{{axis}}_g", 0.0)
        inputs = ["pressure_kPa"]
        inputs += [f"tip_force_{{axis}}_N" for axis in "xyz"]
        inputs += [f"gravity_{{axis}}_g" for axis in "xyz"]
        for name in inputs:
            self.register_variable(Real(name, causality=Fmi2Causality.input,
                                        variability=Fmi2Variability.continuous))
        for name, value in self._state().items():
            setattr(self, name, value)
            self.register_variable(Real(name, causality=Fmi2Causality.output,
                                        variability=Fmi2Variability.continuous))

    def _state(self):
        force = [[getattr(self, f"tip_force_{{axis}}_N") for axis in "xyz"]]
        gravity = [[GRAVITY * getattr(self, f"gravity_{{axis}}_g") for axis in "xyz"]]
        found = self._rod.state([self.pressure_kPa], force, None, gravity)
        return {{name: float(values[0]) for name, values in found.items()}}

    def exit_initialization_mode(self):
        self._take(self._state())

    def do_step(self, current_time, step_size):
        try:
            self._take(self._state())
        except ArithmeticError:  # no equilibrium: the step is discarded
            return False
        return True

    def _take(self, found):
        for name, value in found.items():
            setattr(self, name, value)
'''
