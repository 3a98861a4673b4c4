"""Where a result comes from: the spec's assumptions, versions, times, and how to cite it."""

import json
from typing import Any

from softact.report import labels
from softact.report.base import download
from softact.results.folder import Results

_RESTS_ON = (
    ("Gmsh", "Geuzaine and Remacle 2009", "10.1002/nme.2579"),
    ("DOLFINx", "Baratta et al. 2023", "10.5281/zenodo.10447666"),
    ("MUMPS", "Amestoy et al. 2001", "10.1137/S0895479899358194"),
)


def assumptions(spec: dict) -> list[str]:
    """What the spec says that it had to assume."""
    items = spec.get("assumptions") or []
    return [str(item) for item in items] if isinstance(items, list) else []


def provenance(results: Results) -> list[tuple[str, list[tuple[str, str]]]]:
    """Tables of what run.json says of the run: their heads, and rows of a name and a value."""
    run = results.run
    plain = {k: v for k, v in run.items() if not isinstance(v, dict | list) and v is not None}
    tables = [("Run", _rows(plain))]
    heads = {"times_s": "Times (s)", "mesh": "Mesh", "counts": "Counts", "versions": "Versions"}
    for key, value in run.items():
        if isinstance(value, dict) and value and key != "files":
            head = heads.get(key, key.replace("_", " ").capitalize())
            tables.append((head, _rows(value)))
    return tables


def _rows(items: dict) -> list[tuple[str, str]]:
    return [(str(key).replace("_", " "), _text(value)) for key, value in items.items()]


def _text(value: Any) -> str:
    if isinstance(value, float):
        return labels.number(value)
    if isinstance(value, int) and not isinstance(value, bool):
        return f"{value:,}".replace(",", " ")
    return value if isinstance(value, str) else json.dumps(value)


def cite(results: Results, name: str) -> dict[str, str]:
    """The command that computes the run again, a link to its spec, and what to cite."""
    run = results.run
    version = run.get("softact") or run.get("softact_version") or run.get("version") or ""
    commit = run.get("git_commit") or run.get("commit") or ""
    which = " ".join(filter(None, [f"softact {version}".strip(), commit and f"({commit})"]))
    mark = f", spec hash {run['spec_hash']}" if run.get("spec_hash") else ""
    rests = "; ".join(f"{tool}: {who}, doi:{doi}" for tool, who, doi in _RESTS_ON)
    processes = f" -n {run['processes']}" if run.get("processes") else ""
    return {
        "command": f"softact run spec.yaml{processes} -o results/{name}",
        "download": download("spec.yaml", results.spec_yaml.encode(), "text/yaml"),
        "computed_with": f"{which}{mark}",
        "rests_on": rests,
    }
