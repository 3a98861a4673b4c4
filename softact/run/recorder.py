"""Runs the steps of a spec and writes down each accepted state."""

from __future__ import annotations

import resource
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from softact.loads.air_account import Account
from softact.measures import MEASURES
from softact.measures.failure import SHARE
from softact.measures.further_fields import further_fields
from softact.measures.points import locate
from softact.measures.snapshot import Snapshot, gather_mesh, gather_nodes
from softact.measures.target_line import Followed, followed
from softact.results.folder import NO_EQUILIBRIUM, read
from softact.run.films import compressed_layers
from softact.run.from_spec import load_steps, parameters, supports_of
from softact.run.last_state import why_not
from softact.run.nearby import Nearby, nearby
from softact.run.resuming import identity
from softact.run.slopewise import Slopewise
from softact.run.unstable import unstable_text
from softact.sensitivities.following import Following
from softact.solve.at_once import found_at_once
from softact.solve.checkpoint import Checkpoint, pack
from softact.solve.generalised_alpha import energies
from softact.solve.progress import Attempt, Trying
from softact.solve.stepping import Stepper
from softact.spec import plausible
from softact.system import blas
from softact.verdict import efficiency, frequency_response, in_time, step_response
from softact.verdict.judge import AMBER, RED, Reason, Verdict, judge

if TYPE_CHECKING:
    from softact.loads.load_step import LoadStep
    from softact.loads.support import Support
    from softact.model import Model
    from softact.results.writer import ResultsWriter
    from softact.sensitivities.twin import Twin
    from softact.spec import Spec
    from softact.system.term import State

# Seconds without an event after which it is told what the solver tries.
SILENCE = 5.0
CARRIED = "payload_energy_mJ"  # a column of runs in which the actuator carries something


class Recorder:
    """Runs the steps of a spec and writes down each accepted state.

    notes: on the mesh, which stand with those of the run itself. twins: of the parameters by which
    the measures are differentiated. start, begin: see ``Stepper.run``.
    """

    def __init__(
        self,
        spec: Spec,
        model: Model,
        writer: ResultsWriter | None,
        tell: Callable[[dict], None],
        start: Checkpoint | None,
        notes: Sequence[str] = (),
        twins: Sequence[Twin] = (),
        begin: int | None = 0,
    ):
        self.spec, self.model, self.writer, self._tell = spec, model, writer, tell
        self.notes, self._told_at = notes, time.monotonic()
        wanted = MEASURES if spec.measures == "all" else dict.fromkeys(spec.measures)
        self.measures = [MEASURES[name] for name in wanted]
        self.probes = locate(model, spec.probes)
        self.followed: Followed | None = None
        if spec.target_line is not None:
            self.followed = followed(model, spec.target_line.through, spec.target_line.points)
        self.timed = any(step.timing(spec.geometry.layout()) for step in spec.steps)
        self.moves = any(step.dynamics is not None for step in spec.steps)
        heard = self._accept, self._reject, self._checkpoint, self._try, self._remark
        self.stepper = Stepper(model, spec.solver.settings, *heard)
        self._open_accounts()
        self.slopes: Slopewise | None = None
        if twins:
            following = Following(self.stepper.walk, twins, self._of_twin)
            if start is not None:
                following.resume(start, begin)
            self.slopes = Slopewise(following, writer, start)
        self.row: dict = model.comm.bcast(writer.last_row if writer is not None else None)
        self.near: Nearby | None = None
        self.snapshot: Snapshot | None = None  # of the state that is being accepted
        self.write_time = 0.0
        self.verdict: Verdict | None = None  # on rank 0, at the end
        self.identity = identity(spec) if writer is not None else {}
        if start is None:
            self._write_mesh()

    def _open_accounts(self) -> None:
        """Let the first state have all columns of air that later ones have."""
        filled = {
            name
            for step in self.spec.steps
            for key in ("supply", "exhaust")
            for name in step.loads.get(key, ())
        }
        state = self.stepper.walk.state
        for name in sorted(filled):
            state.memory |= Account().named(name)

    def tell(self, event: dict) -> None:
        """Tell what happens."""
        self._told_at = time.monotonic()
        self._tell(event)

    def _try(self, trying: Trying) -> None:
        """Tell what is being tried, where nothing has been told for a while."""
        if time.monotonic() - self._told_at > SILENCE:
            self.tell({"stage": "progress", **asdict(trying)})

    def _write_mesh(self) -> None:
        gathered = gather_mesh(self.model)
        if gathered is not None and self.writer is not None:
            points, cells, region, surfaces = gathered
            layout = self.model.mesh.layout
            names = layout.regions or layout.sheets
            self.writer.mesh(points, cells, region, names, surfaces, layout)

    def guess_from(self, directory: Path) -> None:
        """Seek the last state alone, from that of the run of an actuator like this one; as far as
        that can be, or it is told why not."""
        found = why_not(self.spec) or nearby(self.model, self.spec, directory)
        if isinstance(found, str):
            self._begin_anew(found)
        else:
            self.near = found

    def _begin_anew(self, why: str) -> None:
        text = f"solved from the beginning, and not from the run nearby: {why}"
        self.notes = [*self.notes, text]
        self.tell({"stage": "note", "text": text})

    def _solved_at_once(self, steps: Sequence[LoadStep], supports: Sequence[Support]) -> bool:
        """Whether the last state was found from the run nearby."""
        if self.near is None:
            return False
        walk, guesses = self.stepper.walk, self.near.guesses
        if found_at_once(walk, steps, supports, guesses, self._skip_to):
            return True
        self._begin_anew("Newton's method did not get from its state to this one")
        return False

    def _skip_to(self, number: int) -> None:
        """Count on from the run nearby, as that is where the walk goes on."""
        assert self.near is not None
        self.row = {**self.row, **self.near.row}
        if self.slopes is not None:
            self.slopes.following.skip_to(number, self.near.row)

    def run(self, times: dict, start: Checkpoint | None, begin: int | None) -> str:
        """Solve and write; returns the status. times: seconds of the stages, to which those of the
        run are added. start, begin: see ``Stepper.run``."""
        started = time.perf_counter()
        steps, supports = load_steps(self.spec, self.model), supports_of(self.spec.supports or ())
        if self._solved_at_once(steps, supports):
            progress = self.stepper.progress
        else:
            progress = self.stepper.run(steps, supports, start, begin)
        beside = self.write_time + (self.slopes.time if self.slopes else 0.0)
        times["solve"] = time.perf_counter() - started - beside
        times |= {"measure_and_write": self.write_time, **self.stepper.walk.newton.times}
        memory = self.model.comm.allreduce(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
        status = "no_equilibrium" if progress.stopped else "complete"
        self.tell({"stage": "solved", "status": status})
        messages = [progress.stopped, *progress.remarks, self._unstable(), *self._beyond_test()]
        messages += compressed_layers(self.model, self.stepper.state)
        messages += plausible.lines(self.spec)
        messages = [message for message in messages if message]
        if self.writer is not None:
            if self.slopes is not None:
                times["sensitivities"] = self.slopes.time
            summary = parameters(self.spec) | self.row
            if CARRIED in self.row:
                summary |= efficiency.figures(read(self.writer.directory))
            counts = {
                "increments": len(progress.attempts) - progress.cutbacks - 1,
                "cutbacks": progress.cutbacks,
                **asdict(self.stepper.walk.newton.counts),
            }
            notes = [*self.notes, *progress.notes, *self._not_followed]
            record: dict = {"messages": messages, "notes": notes}
            started = time.perf_counter()
            record["notes"] += self._to_say(self.writer.directory)
            self.verdict = self._judge(self.writer.directory, status, record)
            times["judge"] = time.perf_counter() - started
            record |= {
                "verdict": self.verdict.data(),
                "times_s": {name: round(t, 4) for name, t in times.items()},
                "counts": counts,
                "memory_MB": round(memory / 1024),
                "history": [asdict(a) for a in progress.attempts],
            }
            analysis = self.stepper.walk.newton.factor.analysis
            if analysis is not None:
                record["factorisation"] = asdict(analysis) | {"kernels": blas.taken()}
            self.writer.finish(status, summary, record)
        done = {"stage": "done", "status": status, "message": progress.stopped}
        self.tell({**done, "verdict": self.verdict and self.verdict.data(places=True)})
        return status

    def _to_say(self, directory: Path) -> list[str]:
        """What to say of cycles, creep, motions and loads that are lifted, and tell it."""
        told = [in_time, step_response, frequency_response] if self.timed else []
        told += [efficiency] if CARRIED in self.row else []
        results = read(directory) if told else None
        said = [line for part in told for line in part.lines(results)]
        for line in said:
            self.tell({"stage": "note", "text": line})
        return said

    @property
    def _not_followed(self) -> list[str]:
        """From where on there are no derivatives, and why."""
        return self.slopes.notes if self.slopes is not None else []

    def _judge(self, directory: Path, status: str, record: dict) -> Verdict:
        """The verdict on what has been written, and on what run.json will say."""
        try:
            return judge(replace(read(directory), run={"status": status, **record}))
        except Exception as error:  # the run is worth more than what is thought of it
            colour = RED if status == NO_EQUILIBRIUM else AMBER
            return Verdict(colour, (Reason("unread", f"no verdict could be reached: {error!r}"),))

    def _unstable(self) -> str | None:
        """What to say of unstable equilibria."""
        found = [attempt for attempt in self.stepper.progress.attempts if attempt.converged]
        # With friction the factors tell nothing of a state that seems to be stable.
        return unstable_text(found, again=self.model.contacts.symmetric)

    def _beyond_test(self) -> list[str]:
        """What to say of material that is stretched further at the end than its card was tested."""
        said = []
        for name, solid in self.model.solids.items():
            card = solid.material.card
            if card is None or card.stretch_range is None:
                continue
            f = solid.deformation_gradient(self.stepper.state.x)
            stretch = np.linalg.svd(f, compute_uv=False)
            low, high = card.stretch_range
            beyond = stretch[..., 0] > high
            if low < 1:  # a tension test says nothing of its transverse stretches below 1
                beyond |= stretch[..., -1] < low
            part = self.model.sum(float(solid.volumes[beyond].sum()))
            whole = self.model.sum(float(solid.volumes.sum()))
            if part > SHARE * whole:  # at a sharp corner some is stretched beyond any test
                said.append(
                    f"region '{name}': {part / whole:.2%} of the volume leaves the stretches "
                    f"{low:g} to {high:g} to which {card.name or 'its material'} was tested: what "
                    "the law says there is an extrapolation"
                )
        return said

    def _measured(self, snapshot: Snapshot) -> dict[str, float | str]:
        """The measures of a state."""
        row: dict[str, float | str] = {}
        for measure in self.measures:
            row |= measure.evaluate(snapshot)
        return row

    def _of_twin(self, twin: Twin) -> dict[str, float | str]:
        """Those of a twin, whose probes stay in their elements."""
        safety = self.spec.safety_factor
        known = self.probes, self.followed, self.snapshot
        return self._measured(Snapshot(twin.model, twin.state, twin.row, safety, *known))

    def _accept(self, state: State, attempt: Attempt, number: int) -> None:
        started = time.perf_counter()
        snapshot = Snapshot(
            self.model, state, self.row, self.spec.safety_factor, self.probes, self.followed
        )
        row: dict[str, float | str] = {
            "step": attempt.step,
            "increment": number,
            "step_fraction": attempt.fraction,
            **self._measured(snapshot),
        }
        if self.timed:
            row["time_s"] = state.clock.now
        if self.moves:
            row |= energies(self.model, state)
        row["unstable_modes"] = attempt.unstable_modes
        row["control"], row["kinetic_ratio"] = attempt.control, attempt.kinetic_ratio
        row["newton_iterations"] = attempt.iterations
        row["residual"] = attempt.residuals[-1] if attempt.residuals else 0.0
        self.row = row
        # Gathered by all processes; only the one that writes gets them.
        nodal = snapshot.nodal_fields() | further_fields(snapshot, self.spec.fields)
        fields = {
            name: gathered
            for name, values in nodal.items()
            if (gathered := gather_nodes(self.model, values)) is not None
        }
        if self.writer is not None:
            self.writer.increment(row, fields)
        self.write_time += time.perf_counter() - started
        if self.slopes is not None:
            self.snapshot = snapshot
            self.slopes.accept(state, attempt, number, row)
            self.snapshot = None
        self.tell({"stage": "increment", "steps": len(self.spec.steps), **asdict(attempt), **row})

    def _checkpoint(self, checkpoint: Checkpoint) -> None:
        started = time.perf_counter()
        curve = self.writer.curve if self.writer is not None else ""
        kept = replace(checkpoint, curve=curve, spec=self.identity)
        if self.slopes is not None:
            beside, vectors = self.slopes.following.kept()
            kept = replace(kept, beside=beside, vectors=vectors)
        data = pack(self.model, kept)
        if self.writer is not None and data is not None:
            self.writer.checkpoint(data)
        self.write_time += time.perf_counter() - started

    def _remark(self, text: str) -> None:
        self.tell({"stage": "note", "text": text})

    def _reject(self, attempt: Attempt) -> None:
        self.tell({"stage": "cutback", **asdict(attempt)})
