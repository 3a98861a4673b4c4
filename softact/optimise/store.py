"""trials.db: the trials of an optimisation in a file that is whole and of this optimisation, or
refused."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator, Mapping
from contextlib import closing, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from softact.errors import CannotWriteError, SoftactError, SpecError
from softact.files.text import replacing
from softact.optimise.spec import Optimisation
from softact.sweep.version import version

if TYPE_CHECKING:
    import optuna

DATABASE = "trials.db"
_NAME = "softact"
#: Keys of the file that decide what a trial is; the base is compared run by run.
_DECIDES = {"parameters", "objectives", "constraints", "seed", "reference", "method", "starts",
            "model", "blocked"}  # fmt: skip


def opened(wanted: Optimisation, directory: Path, first: Mapping[str, Any]) -> optuna.Study:
    """Optuna's study in a folder, made where there is none.

    first: parameters of the first trial of a new one, empty for none. Raises SpecError where the
    file is damaged, of other parameters, objectives or constraints, or of another softact.
    """
    file = directory / DATABASE
    with reading(file):
        if file.exists():
            _check_whole(file)
        else:
            _make(file, wanted, first)
        study = _study(file)
        _check_same(study.user_attrs, wanted, file)
    return study


@contextmanager
def reading(file: Path) -> Iterator[None]:
    """Turn whatever comes of a damaged file into a SpecError that says what to do."""
    try:
        yield
    except (SoftactError, OSError, MemoryError):
        raise
    except Exception as error:  # whatever Optuna, SQLAlchemy and SQLite make of a damaged file
        raise damaged(file, error) from None


def damaged(file: Path, why: object) -> SpecError:
    """What to say of a file that is not as it was written."""
    words = " ".join(str(why).split())[:120]
    return SpecError(
        f"{file}: cannot be read ({words}); move it away: the same command makes the same trials "
        "again from the runs in the cache"
    )


@contextmanager
def writing(file: Path) -> Iterator[None]:
    """Turn what SQLite says of a full disk or a folder that is gone into a CannotWriteError."""
    from sqlalchemy.exc import SQLAlchemyError

    try:
        yield
    except (SQLAlchemyError, sqlite3.Error) as error:
        words = " ".join(str(getattr(error, "orig", None) or error).split())[:120]
        raise CannotWriteError(
            f"{file}: cannot be written ({words}); what was finished is kept"
        ) from None


def _check_whole(file: Path) -> None:
    with closing(sqlite3.connect(file)) as connection:
        (found,) = connection.execute("PRAGMA integrity_check(1)").fetchone()
        if found != "ok":
            raise damaged(file, found)
        # Optuna would add its tables to whatever else the file holds.
        query = "SELECT COUNT(*) FROM studies WHERE study_name = ?"
        if connection.execute(query, (_NAME,)).fetchone() != (1,):
            raise damaged(file, "it holds no study of softact")


def _make(file: Path, wanted: Optimisation, first: Mapping[str, Any]) -> None:
    """A new file, which has the whole study from its first moment."""
    import optuna

    # A journal that outlived its file would be played into the new one.
    file.with_name(f"{file.name}-journal").unlink(missing_ok=True)
    with replacing(file) as temporary:
        study = optuna.create_study(
            study_name=_NAME,
            storage=_storage(temporary),
            directions=[objective.direction for objective in wanted.objectives],
        )
        study.set_user_attr("file", wanted.model_dump_json(include=_DECIDES))
        study.set_user_attr("version", version())
        if first:
            study.enqueue_trial(dict(first))


def _study(file: Path) -> optuna.Study:
    import optuna

    return optuna.load_study(study_name=_NAME, storage=_storage(file))


def _storage(file: Path) -> optuna.storages.RDBStorage:
    """Optuna's storage. By a function and no address, in which '?', '%' and braces mean more."""
    import optuna
    from sqlalchemy.pool import NullPool

    def connect() -> sqlite3.Connection:
        return sqlite3.connect(file)

    return optuna.storages.RDBStorage(
        "sqlite://", engine_kwargs={"creator": connect, "poolclass": NullPool}
    )


def _check_same(known: Mapping[str, Any], wanted: Optimisation, file: Path) -> None:
    for name, here, what in (
        ("file", wanted.model_dump_json(include=_DECIDES), "another optimisation"),
        ("version", version(), "another version of softact or of its packages"),
    ):
        if known.get(name) != here:
            raise other(file, f"holds the trials of {what}")


def other(file: Path, why: str) -> SpecError:
    """What to say of trials that are not to be mixed with those of this call."""
    return SpecError(f"{file}: {why}; name another folder with -o DIR, or move the file away")
