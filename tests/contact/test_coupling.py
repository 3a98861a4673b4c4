"""Room in the matrix for facets that touch."""

from types import SimpleNamespace

import numpy as np

from softact.contact.coupling import NodeCoupling


def test_the_matrix_is_laid_out_only_for_what_has_no_room():
    """Pairs of facets of their own nodes: what is near costs nothing, what touches has room from
    then on, and of what was there long ago no more is kept than there is now."""
    layouts = []
    slots = SimpleNamespace(set=lambda rows, columns: layouts.append(len(rows)))
    facets = SimpleNamespace(
        nodes=np.arange(60).reshape(20, 3), count=60, first=3 * np.arange(60, dtype=np.int64)
    )
    coupling = NodeCoupling(SimpleNamespace(couple_loosely=lambda: slots), facets)

    def pairs(*of):
        return [np.array(of, dtype=np.int64).reshape(-1, 2)]

    coupling.make_room(pairs(), pairs((0, 1)))
    assert not layouts
    coupling.make_room(pairs((0, 1)), pairs((0, 1), (2, 3)))
    coupling.make_room(pairs((3, 2)), pairs((2, 3)))
    assert layouts == [(2 * 9 * 2 + 4 * 9) * 9]  # two pairs both ways, four facets with themselves
    coupling.make_room(pairs((4, 5)), pairs((4, 5), (6, 7)))
    coupling.make_room(pairs((0, 1)), pairs((0, 1)))
    assert layouts == [layouts[0], 2 * layouts[0]]
    coupling.make_room(pairs((8, 9)), pairs((8, 9)))
    assert layouts[2] == layouts[0] // 2
