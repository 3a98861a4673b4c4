/* MUMPS's own structure, as far as PETSc does not hand it on: the given order of the pivots.
 *
 * HEADER is the name of dmumps_c.h.
 */
#include HEADER
#include <string.h>

/* Whether the structure is as the header says: of its version, which MUMPS wrote into it. */
int mumps_fits(const DMUMPS_STRUC_C *id)
{
    return sizeof(MUMPS_INT) == 4 && strncmp(id->version_number, MUMPS_VERSION, MUMPS_VERSION_MAX_LEN) == 0;
}

/* Analyse the matrix that the structure holds. ordering: ICNTL(7); order: place of each unknown
 * among the pivots, from 1, on rank 0 where it is given. Collective. */
void mumps_analyse(DMUMPS_STRUC_C *id, void (*dmumps)(DMUMPS_STRUC_C *), int ordering,
                   MUMPS_INT *order)
{
    id->icntl[6] = ordering;
    id->perm_in = order;
    id->job = 1;
    dmumps(id);
    id->perm_in = 0; /* the caller's, and read by the analysis alone */
}
