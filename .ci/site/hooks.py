"""MkDocs hooks of softact's site: pages that docs/ does not hold, and links that leave it.

A page of docs/ is read in the repository, too: its links to other files there stay as they are in
the source. On the site they lead to a copy of the file.
"""

import json
import os
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import click
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

ROOT = Path(__file__).resolve().parents[2]
BESIDE = ("CONTRIBUTING.md", "CHANGELOG.md")
COPIES = "repository"  # folder of the site with files that pages link to
LINK = re.compile(r"(\]\()(?!#|[a-z][a-z0-9+.-]*:)([^)#\s]+)")
CODE = re.compile(r"(```.*?```|`[^`\n]*`)", re.S)


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages and the files that pages link to."""
    for name in BESIDE:
        text = (ROOT / name).read_text(encoding="utf-8")
        files.append(File.generated(config, name, content=text))
    files.append(File.generated(config, "commands.md", content=commands()))
    for notebook in sorted((ROOT / "docs/notebooks").glob("*.ipynb")):
        uri = f"notebooks/{notebook.stem}.md"
        files.append(File.generated(config, uri, content=as_page(notebook)))
    for target in sorted(wanted(files)):
        path = ROOT / target
        files.append(File.generated(config, site_place(target), abs_src_path=str(path)))
    return files


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """The text with links as the site has its files."""
    uri = page.file.src_uri

    def rewritten(match: re.Match[str]) -> str:
        target = site_place(in_repository(uri, match[2]))
        return match[1] + os.path.relpath(target, os.path.dirname(uri) or ".")

    return outside_of_code(markdown, lambda text: LINK.sub(rewritten, text))


def outside_of_code(markdown: str, change: Any) -> str:
    """Markdown with a change in all but its code."""
    parts = CODE.split(markdown)
    return "".join(part if number % 2 else change(part) for number, part in enumerate(parts))


def in_repository(uri: str, link: str) -> str:
    """The path from the top of the repository that a page's link leads to."""
    page = uri if uri in BESIDE else f"docs/{uri}"
    return os.path.normpath(os.path.join(os.path.dirname(page), unquote(link)))


def site_place(path: str) -> str:
    """The place on the site of a file of the repository."""
    if path in BESIDE:
        return path
    if path.startswith("docs/"):
        path = path.removeprefix("docs/")
        return path.replace(".ipynb", ".md") if path.startswith("notebooks/") else path
    return f"{COPIES}/{path.lstrip('.')}"  # MkDocs leaves out what begins with a dot


def wanted(files: Files) -> Iterator[str]:
    """Files outside of docs/ that pages link to, each once; those that are missing are left to
    MkDocs, which names them."""
    found = set()
    for file in files.documentation_pages():
        for part in CODE.split(file.content_string)[::2]:
            found |= {in_repository(file.src_uri, match[2]) for match in LINK.finditer(part)}
    for path in found:
        if site_place(path).startswith(f"{COPIES}/") and (ROOT / path).is_file():
            yield path


def commands() -> str:
    """The page of all commands, as `--help` has them."""
    from softact.cli.main import softact

    top = click.Context(softact, info_name="softact")
    lines = ["# Commands", "", "Each is what `softact COMMAND --help` prints.", ""]
    for name in softact.list_commands(top):
        command = softact.get_command(top, name)
        assert command is not None
        context = click.Context(command, parent=top, info_name=name, max_content_width=88)
        lines += [f"## softact {name}", "", "```text", command.get_help(context), "```", ""]
    return "\n".join(lines)


def as_page(notebook: Path) -> str:
    """A notebook as Markdown, with what its cells printed."""
    cells = json.loads(notebook.read_text(encoding="utf-8"))["cells"]
    parts = [f"[This page as a notebook]({notebook.name})"]
    for cell in cells:
        source = "".join(cell["source"])
        if cell["cell_type"] == "markdown":
            parts.append(source)
        else:
            parts.append(f"```python\n{source}\n```")
            parts += [shown(output) for output in cell["outputs"]]
    head, title = parts[0], parts[1]
    return "\n\n".join([title, head, *parts[2:]])


def shown(output: dict[str, Any]) -> str:
    """What a cell of a notebook has put out, as Markdown."""
    if "text" in output:
        return f"```text\n{''.join(output['text']).rstrip()}\n```"
    data = output["data"]
    if "image/png" in data:
        picture = "".join(data["image/png"]).replace("\n", "")
        return f"![what the cell draws](data:image/png;base64,{picture})"
    if "text/html" in data:
        table = re.sub(r"(?s)<style.*?</style>|\n\s*", "", "".join(data["text/html"]))
        return re.sub("<table[^>]*>", "<table>", table)
    return f"```text\n{''.join(data['text/plain'])}\n```"
