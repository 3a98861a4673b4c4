"""What so many modules do, by hand."""

import numpy as np
import pytest

from softact.results import chain

CURVE = {
    "step": np.array(["a", "a", "b"], dtype=object),
    "step_fraction": np.array([0.5, 1.0, 0.5]),
    "pressure_kPa": np.array([1.0, 2.0, 3.0]),
    "bending_angle_deg": np.array([1.0, 2.0, 4.0]),
    "chord_angle_deg": np.array([0.5, 1.0, 2.0]),
    "tip_x_mm": np.array([9.0, 8.0, 7.0]),
    "module_angle_y_deg": np.array([1.0, 2.0, 4.0]),
    "cavity_volume_upper_mm3": np.array([10.0, 20.0, 30.0]),
    "max_principal_stress_MPa": np.array([0.1, 0.2, 0.3]),
    "mass_g": np.array([2.0, 2.0, 2.0]),
}


def test_what_adds_up_is_so_many_times_and_what_is_of_the_ends_is_not_there():
    found = chain.whole(CURVE, 3.5)
    for name in ("bending_angle_deg", "cavity_volume_upper_mm3", "mass_g"):
        assert found[name] == pytest.approx(3.5 * CURVE[name])
    for name in ("pressure_kPa", "max_principal_stress_MPa", "module_angle_y_deg"):
        assert found[name] == pytest.approx(CURVE[name])
    assert found["actuator_angle_y_deg"] == pytest.approx([3.5, 7.0, 14.0])
    assert not {"chord_angle_deg", "tip_x_mm"} & found.keys()


def test_what_is_exerted_is_told_at_the_states_of_the_free_module():
    """The blocked run has other increments: a moment of -1 N*mm at the end of a, -3 in the middle
    of b, where it ends."""
    blocked = {
        "step": np.array(["a", "a", "b"], dtype=object),
        "step_fraction": np.array([0.0, 1.0, 0.25]),
        "module_moment_y_Nmm": np.array([0.0, -1.0, -3.0]),
        "module_force_x_N": np.array([5.0, 5.0, 5.0]),
    }
    found = chain.exerted(CURVE, {"straight": blocked})
    assert list(found) == ["blocked_moment_y_Nmm"]
    assert found["blocked_moment_y_Nmm"] == pytest.approx([0.5, 1.0, np.nan], nan_ok=True)
