"""``--set path=value``: values of a spec replaced from outside its file."""

from collections.abc import Sequence

from softact.errors import SpecError
from softact.files.document import Document, scalar
from softact.spec import path as paths
from softact.spec.models import Spec
from softact.units import show


def apply(document: Document, overrides: Sequence[str]) -> None:
    """Set each ``path=value`` in the document, see ``softact.spec.path``.

    Raises SpecError, one line per override that cannot be.
    """
    faults = []
    for text in overrides:
        try:
            _set(document, text)
        except SpecError as error:
            faults += [f"--set {show(text)[1:-1]}: {line}" for line in error.lines]
    if faults:
        raise SpecError(*faults)


def _set(document: Document, text: str) -> None:
    path, equals, written = text.partition("=")
    if not equals or not all(key.strip() for key in path.split(".")):
        raise SpecError("write a dotted path, '=' and a value, for example steps.0.pressure=30 kPa")
    paths.assign(document, path, scalar(written), paths.replaced(path, written), Spec)
