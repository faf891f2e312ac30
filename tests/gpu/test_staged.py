"""How many threads a block has, so that its rows have room in shared memory."""

import pytest

import ulna

pytest.importorskip("numba_cuda", reason="numba-cuda is in an environment of its own: make test-cuda")

from ulna.gpu.device import THREADS
from ulna.gpu.staged import over_rows, threads_for

ROOM = 49152  # bytes that every NVIDIA GPU gives a block


def formula(*_):
    return False


@pytest.mark.parametrize("n_dof", [1, 6, 7, 20, 50, 100])
def test_the_rows_of_a_block_have_room(n_dof):
    threads = threads_for(n_dof, 6 * n_dof)
    assert 1 <= threads <= THREADS
    assert 8 * threads * ((n_dof | 1) + (6 * n_dof | 1)) <= ROOM
    assert over_rows(formula, n_dof, 6 * n_dof).threads == threads


def test_a_row_of_several_threads_is_not_cut_between_blocks():
    assert threads_for(16, 6, 8) % 8 == 0
    assert threads_for(10_000, 6, 8) == 8


@pytest.mark.parametrize("n_dof", [78, 200])
def test_rows_that_do_not_fit_are_refused(n_dof):
    """As of the mass matrix of an arm with so many joints."""
    over_rows(len, n_dof, 77 * 77)
    with pytest.raises(ulna.DeviceError, match=rf"{n_dof} numbers and {n_dof**2} results of a problem need \d+ kB"):
        over_rows(len, n_dof, n_dof**2)


def test_the_panda_fills_its_blocks():
    assert threads_for(7, 16) == THREADS
    assert threads_for(7, 42) >= 64
