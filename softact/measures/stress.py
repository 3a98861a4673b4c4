"""Largest stresses and where they are."""

from softact.measures.base import Measure, vector_columns


def _evaluate(snapshot):
    value, place = snapshot.largest(snapshot.max_principal_stress)
    columns = {"max_principal_stress_MPa": value}
    columns |= vector_columns("max_principal_stress_<xyz>_mm", place)
    columns["max_von_mises_MPa"] = snapshot.largest(snapshot.von_mises)[0]
    return columns


STRESS = Measure(
    "stress",
    "largest Cauchy stress (nodal means) and its place in the undeformed actuator",
    {"max_principal_stress_MPa": "largest principal Cauchy stress"}
    | {f"max_principal_stress_{c}_mm": f"its undeformed {c} coordinate" for c in "xyz"}
    | {"max_von_mises_MPa": "largest von Mises stress"},
    _evaluate,
)
