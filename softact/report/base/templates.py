"""The templates of the pages. Whatever is put into one is escaped, unless it is ``Markup``."""

from functools import cache
from importlib.resources import files
from typing import TYPE_CHECKING, Any

from markupsafe import Markup

if TYPE_CHECKING:
    from jinja2 import Environment


def render(template: str, **shown: Any) -> str:
    """The text of a template. template: its path below the package, such as "sweep/sweep.html"."""
    return _environment().get_template(template).render(shown)


def load(*templates: str) -> None:
    """Compile templates ahead of ``render``: those that they extend or call are named too."""
    for template in templates:
        _environment().get_template(template)


def macros(template: str) -> Any:
    """The macros of a template as attributes: called from Python, each gives ``Markup``."""
    return _environment().get_template(template).module


def text_of(path: str) -> Markup:
    """A style sheet or a script of the package as it is; in templates, too."""
    return Markup((files("softact") / path).read_text(encoding="utf-8"))


@cache
def _environment() -> "Environment":
    # Imported here: most who take a label or a plot from this package write no page.
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(
        loader=PackageLoader("softact", ""),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        auto_reload=False,
    )
    environment.globals["text_of"] = text_of
    # The filter ``tojson``: strict, and with the columns of a CSV in their order.
    environment.policies["json.dumps_kwargs"] = {"separators": (",", ":"), "allow_nan": False}
    return environment
