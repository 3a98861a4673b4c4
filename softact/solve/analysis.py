"""The order in which a matrix's unknowns are eliminated: MUMPS's own or METIS's nested dissection,
whichever takes fewer operations by MUMPS's own analysis."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from petsc4py import PETSc

from softact.model import Model
from softact.solve import mumps
from softact.solve.ordering import metis, nested_dissection

METIS = "METIS"
# An order of an earlier matrix is kept until a factorisation takes so many times the operations.
WORSE = 1.25
# METIS's order is tried in MUMPS where it takes at most this part of its own order's operations by
# our count, which is lower than MUMPS's: an analysis costs as much as a factorisation.
GAIN = 0.9


@dataclass(frozen=True)
class Analysis:
    """What a direct solver said of a matrix before its factorisation.

    ordering: of the pivots. operations: floating point operations of one factorisation, by the
    orderings that were tried. memory_MB: of the factors and working space as estimated, all
    processes. untried: why METIS was not among them, "" where it was. solver: its name.
    """

    ordering: str
    operations: Mapping[str, float]
    memory_MB: int  # noqa: N815 (a unit)
    untried: str = ""
    solver: str = "MUMPS"


class Analyst:
    """Analyses of the matrices of one model.

    Both orderings are tried on the first matrix; later ones, whose pattern hardly differs, are
    analysed with the better of them, and METIS's order is kept as long as it does. last: the last
    analysis. kept: the ordering that is used from now on; None: not decided.
    """

    last: Analysis | None = None
    kept: str | None = None
    _order: np.ndarray | None = None
    _operations = 0.0  # of the matrix that the order was made for
    _counted: float | None = None  # by METIS's order, before MUMPS's analysis

    def __init__(self, model: Model):
        self._model = model

    def analyse(self, factors: PETSc.Mat) -> None:
        """MUMPS's analysis of the model's matrix, whose values are there. Collective."""
        matrix, symmetric = self._model.assembler.matrix, self._model.contacts.symmetric
        mumps.analyse(factors, matrix, symmetric)
        self.last = first = _said(factors)
        if self.kept not in (None, METIS) or factors.getMumpsIcntl(7) != mumps.ANY:
            return  # the user may have chosen an ordering by an option of PETSc's
        structure = mumps.Structure(self._model.comm, factors)
        why = structure.fault or ("" if metis() else "PETSc is not linked to METIS")
        if why or not self._dissect(factors, structure):
            self.kept = first.ordering
            counted = {} if why or not self._counted else {METIS: self._counted}
            said = why or ("" if counted else "METIS found no order")
            self.last = replace(first, operations={**first.operations, **counted}, untried=said)
            return
        second = _said(factors, METIS)
        found = {**first.operations, **second.operations}
        if found[METIS] < (np.inf if self.kept == METIS else found[first.ordering]):
            self.kept, self.last = METIS, replace(second, operations=found)
            return
        structure.analyse(mumps.ANY)
        self.kept, self.last = first.ordering, replace(first, operations=found)

    def _dissect(self, factors: PETSc.Mat, structure: mumps.Structure) -> bool:
        """Analyse the matrix with METIS's order; whether there is one that may be the better."""
        if self._operations:
            structure.analyse(mumps.GIVEN, self._order)
            if _operations(factors) < WORSE * self._operations:
                return True
        dissection, comm = nested_dissection(self._model.assembler), self._model.comm
        self._operations = 0.0
        self._order = dissection.places if dissection else None
        self._counted = comm.bcast(dissection.operations if dissection else None)
        own = np.inf if self.kept == METIS else GAIN * _operations(factors)
        if self._counted is None or self._counted > own:
            return False
        structure.analyse(mumps.GIVEN, self._order)
        self._operations = _operations(factors)
        return True


def _operations(factors: PETSc.Mat) -> float:
    """Floating point operations of a factorisation by the last analysis; infinitely many where it
    failed."""
    return np.inf if factors.getMumpsInfog(1) < 0 else factors.getMumpsRinfog(1)


def _said(factors: PETSc.Mat, ordering: str = "") -> Analysis:
    """What the last analysis found."""
    name = ordering or mumps.CHOSEN.get(factors.getMumpsInfog(7), "other")
    return Analysis(name, {name: _operations(factors)}, factors.getMumpsInfog(17))
