"""Where a result comes from: the spec's assumptions, versions, times, and how to cite it."""

import json
from html import escape

from softact.report import labels
from softact.report.base import download
from softact.results.folder import Results

_RESTS_ON = (
    ("Gmsh", "Geuzaine and Remacle 2009", "10.1002/nme.2579"),
    ("DOLFINx", "Baratta et al. 2023", "10.5281/zenodo.10447666"),
    ("MUMPS", "Amestoy et al. 2001", "10.1137/S0895479899358194"),
)


def assumptions(spec: dict) -> str:
    items = spec.get("assumptions") or []
    if not isinstance(items, list) or not items:
        return ""
    listed = "".join(f"<li>{escape(str(item))}</li>" for item in items)
    return (
        "<div class='assumptions'><h3>Assumptions</h3><p>What the source leaves open and the spec "
        f"had to fill in:</p><ul>{listed}</ul></div>"
    )


def provenance(results: Results) -> str:
    run = results.run
    plain = {k: v for k, v in run.items() if not isinstance(v, dict | list) and v is not None}
    tables = [_table("Run", plain)]
    heads = {"times_s": "Times (s)", "mesh": "Mesh", "counts": "Counts", "versions": "Versions"}
    for key, value in run.items():
        if isinstance(value, dict) and value and key != "files":
            tables.append(_table(heads.get(key, key.replace("_", " ").capitalize()), value))
    return f"<div class='tables'>{''.join(tables)}</div>"


def _table(title: str, items: dict) -> str:
    rows = "".join(
        f"<tr><th scope='row'>{escape(str(key).replace('_', ' '))}</th>"
        f"<td>{escape(_text(value))}</td></tr>"
        for key, value in items.items()
    )
    return f"<div><h3>{escape(title)}</h3><table>{rows}</table></div>"


def _text(value) -> str:
    if isinstance(value, float):
        return labels.number(value)
    if isinstance(value, int) and not isinstance(value, bool):
        return f"{value:,}".replace(",", " ")
    return value if isinstance(value, str) else json.dumps(value)


def cite(results: Results, name: str) -> str:
    run = results.run
    version = run.get("softact") or run.get("softact_version") or run.get("version") or ""
    commit = run.get("git_commit") or run.get("commit") or ""
    which = " ".join(filter(None, [f"softact {version}".strip(), commit and f"({commit})"]))
    mark = f", spec hash {run['spec_hash']}" if run.get("spec_hash") else ""
    rests = "; ".join(f"{tool}: {who}, doi:{doi}" for tool, who, doi in _RESTS_ON)
    processes = f" -n {run['processes']}" if run.get("processes") else ""
    command = f"softact run spec.yaml{processes} -o results/{name}"
    return (
        "<p>Compute it again from the <a href='#spec'>spec on this page</a>:</p>"
        f"<pre class='command'>{escape(command)}</pre>"
        f"<p>{download('spec.yaml', results.spec_yaml.encode(), 'text/yaml')}</p>"
        f"<p>Cite as: “{escape(name)}”, computed with {escape(which)}{escape(mark)}. "
        f"Cite also what it rests on: {escape(rests)}.</p>"
    )
