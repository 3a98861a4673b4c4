"""Compiled code is kept, and made anew where what was kept is damaged."""

import subprocess
import sys

import pytest
from mpi4py import MPI

from softact.errors import SoftactError
from softact.system import jit

SOURCE = "int answer(void) { return 42; }\n"


@pytest.fixture
def source(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    path = tmp_path / "answer.c"
    path.write_text(SOURCE)
    return path


def kept(tmp_path):
    (library,) = tmp_path.glob("cache/softact/code-*/answer-*.so")
    return library


def loaded(source):
    """What a process of its own finds: a library stays in the one that has loaded it."""
    program = (
        "import sys\nfrom pathlib import Path\nfrom mpi4py import MPI\n"
        "from softact.system import jit\n"
        "print(jit.load_library(MPI.COMM_SELF, Path(sys.argv[1])).answer())"
    )
    done = subprocess.run([sys.executable, "-c", program, source], capture_output=True, text=True)
    return done.returncode, done.stdout.strip()


@pytest.mark.parametrize("damage", ["cut", "emptied", "zeroed", "one bit", "without its checksum"])
def test_damaged_library_is_made_anew(source, tmp_path, damage):
    assert loaded(source) == (0, "42")
    library = kept(tmp_path)
    whole = library.read_bytes()
    flipped = bytearray(whole)
    flipped[len(whole) // 2] ^= 1
    damaged = {
        "cut": whole[: len(whole) // 2],
        "emptied": b"",
        "zeroed": bytes(len(whole)),
        "one bit": bytes(flipped),
        "without its checksum": whole[:-32],
    }
    library.write_bytes(damaged[damage])
    assert loaded(source) == (0, "42")
    assert library.read_bytes() == whole


def test_sound_library_is_kept(source, tmp_path, monkeypatch):
    jit.load_library(MPI.COMM_SELF, source)
    monkeypatch.setenv("CC", "no-such-compiler")
    assert jit.load_library(MPI.COMM_SELF, source).answer() == 42


def test_what_cannot_be_compiled_or_kept_has_a_remedy(source, monkeypatch):
    monkeypatch.setenv("CC", "no-such-compiler")
    with pytest.raises(SoftactError, match="apt-get install gcc"):
        jit.load_library(MPI.COMM_SELF, source)
    monkeypatch.setenv("XDG_CACHE_HOME", "/proc/cache")  # not even root can write there
    with pytest.raises(SoftactError, match="export XDG_CACHE_HOME="):
        jit.load_library(MPI.COMM_SELF, source)
