"""Errors that a user meets, each with the exit code that the command line promises."""

NOT_IN_LOCALE = "this locale has no such characters; run softact with LC_ALL=C.UTF-8"
NOT_UTF8 = "this name has bytes that are no UTF-8; rename the file or folder"
OUT_OF_MEMORY = "the solver ran out of memory; a larger mesh_size needs less"


class SoftactError(Exception):
    """Base of every error that is told to the user in plain lines, without a traceback.

    ``lines`` holds one line per fault; each says what is wrong, where, and what would be right.
    """

    exit_code = 2

    def __init__(self, *lines: str):
        self.lines = list(lines)
        super().__init__("\n".join(lines))


def reason(error: Exception) -> str:
    """What to say of an error that is not the end, on one line."""
    return "; ".join(error.lines) if isinstance(error, SoftactError) else repr(error)


class SpecError(SoftactError):
    """The spec or another input is wrong (exit 2)."""


class DamagedResultError(SpecError):
    """A file of a result folder is not as softact wrote it (exit 2)."""


class FolderBusyError(SoftactError):
    """Another process of softact writes into the folder at the moment (exit 2)."""


class CannotWriteError(SoftactError):
    """The results could not be written: a full disk, a read-only folder (exit 2)."""


class MeshError(SoftactError):
    """The mesh could not be made: gmsh failed, crashed or ran out of time (exit 3)."""

    exit_code = 3


class GmshKilledError(MeshError):
    """Somebody killed gmsh, as the kernel does where memory is short; another try may end well."""


class NoEquilibriumError(SoftactError):
    """The solver found no further equilibrium; what was reached has been kept (exit 4)."""

    exit_code = 4
