"""How the solver got there: increments, their iterations and residuals, as plots and words."""

from softact.report.base import Plot, figures
from softact.results.folder import Results


def summary(results: Results) -> dict:
    """How many increments were tried and failed, the iterations in all, and plots of iterations and
    residuals."""
    history = _attempts(results)
    plots = [_iterations(history)] if history else []
    if any(item["residuals"] for item in history):
        plots.append(_residuals(history))
    return {
        "tried": len(history),
        "failed": sum(not item["converged"] for item in history),
        "iterations": sum(item["iterations"] for item in history),
        "plots": figures(plots),
    }


def _attempts(results: Results) -> list[dict]:
    """Attempted increments, as run.json has them."""
    return [
        {
            "name": f"{item.get('step', '')} {100 * (item.get('fraction') or 0):.1f} %",
            "iterations": int(item.get("iterations") or 0),
            "converged": bool(item.get("converged")),
            "residuals": [r for r in item.get("residuals") or [] if r],
        }
        for item in results.run.get("history") or []
    ]


def _iterations(history: list[dict]) -> Plot:
    traces = []
    for converged, name, colour in ((True, "accepted", "@c1"), (False, "no equilibrium", "@c2")):
        some = [(n, i) for n, i in enumerate(history, 1) if i["converged"] is converged]
        traces.append({
            "type": "bar", "name": name, "marker": {"color": colour},
            "x": [n for n, _ in some], "y": [item["iterations"] for _, item in some],
            "text": [item["name"] for _, item in some], "textposition": "none",
            "hovertemplate": "%{text}: %{y} iterations<extra></extra>",
        })  # fmt: skip
    table = {
        "attempted increment": list(range(1, len(history) + 1)),
        "step and part of it": [item["name"] for item in history],
        "iterations": [item["iterations"] for item in history],
        "accepted": [item["converged"] for item in history],
    }
    layout = {"barmode": "stack"}
    axes = "Attempted increment", "Iterations"
    return Plot("Newton iterations of each increment", traces, *axes, layout, table, "iterations")


def _residuals(history: list[dict]) -> Plot:
    tried = [(n, item) for n, item in enumerate(history, 1) if item["residuals"]]
    traces = []
    for _, item in tried:
        colour = "@c1" if item["converged"] else "@c2"
        traces.append({
            "type": "scatter", "mode": "lines+markers", "showlegend": False, "opacity": 0.6,
            "x": list(range(len(item["residuals"]))), "y": item["residuals"],
            "line": {"color": colour, "width": 1.2}, "marker": {"size": 4, "color": colour},
            "name": item["name"], "hovertemplate": "%{fullData.name}: %{y:.1e}<extra></extra>",
        })  # fmt: skip
    flat = [(n, i, r) for n, item in tried for i, r in enumerate(item["residuals"])]
    heads = "attempted increment", "iteration", "relative residual"
    table = dict(zip(heads, map(list, zip(*flat, strict=True)), strict=True))
    layout = {
        "showlegend": False,
        "xaxis": {} if len(tried) > 8 else {"dtick": 1},
        "yaxis": {"type": "log", "dtick": 2},
    }
    axes = "Iteration", "Relative residual"
    return Plot("Residual in each increment", traces, *axes, layout, table, "residuals")
