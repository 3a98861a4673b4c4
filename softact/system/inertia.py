"""How many eigenvalues of a sparse symmetric matrix are below zero, by its factors."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import scipy.sparse

#: What MUMPS is told so that its factors say their inertia.
MUMPS_CONTROLS = {
    13: 1,  # no ScaLAPACK on the root: it would hide its inertia
    24: 1,  # find null pivots; PETSc asks for it before it tells the inertia
}
MORE_SPACE = 14, 60  # percent of working space above MUMPS's estimate


def negative_eigenvalues(matrix: scipy.sparse.csr_matrix) -> int:
    """Of a symmetric matrix of one process (Sylvester's law of inertia)."""
    # Imported here: commands that solve nothing know the measures, too.
    from petsc4py import PETSc

    entries = (matrix + matrix.T).tocsr() / 2
    entries.sort_indices()
    csr = tuple(a.astype(PETSc.IntType) for a in (entries.indptr, entries.indices))
    found = PETSc.Mat().createAIJ(entries.shape, csr=(*csr, entries.data), comm=PETSc.COMM_SELF)
    factors = PETSc.PC().create(PETSc.COMM_SELF)
    try:
        found.setOption(PETSc.Mat.Option.SYMMETRIC, True)
        factors.setOperators(found)
        factors.setType(PETSc.PC.Type.CHOLESKY)
        factors.setFactorSolverType("mumps")
        factors.setFactorSetUpSolverType()
        for control, value in [*MUMPS_CONTROLS.items(), MORE_SPACE]:
            factors.getFactorMatrix().setMumpsIcntl(control, value)
        factors.setUp()
        return int(factors.getFactorMatrix().getInertia()[0])
    finally:
        factors.destroy()
        found.destroy()
