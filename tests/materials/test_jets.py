"""Taylor numbers against derivatives worked out by hand."""

import numpy as np
import pytest

from softact.materials.jets import Exponential, Series, at_least, positive, variables

X, Y = np.array([0.7, 1.3, 2.1]), np.array([0.4, -0.2, 1.1])


def test_product_quotient_and_functions_in_two_variables():
    x, y = variables(X, Y)
    f = x**2 * y + np.exp(y) / x - np.log(x) * 3.0 + np.sqrt(x) - (2.0 - y)
    assert np.allclose(f.value, X**2 * Y + np.exp(Y) / X - 3 * np.log(X) + np.sqrt(X) - 2 + Y)
    assert np.allclose(f.gradient[0], 2 * X * Y - np.exp(Y) / X**2 - 3 / X + 0.5 / np.sqrt(X))
    assert np.allclose(f.gradient[1], X**2 + np.exp(Y) / X + 1)
    assert np.allclose(f.hessian[0, 0], 2 * Y + 2 * np.exp(Y) / X**3 + 3 / X**2 - 0.25 / X**1.5)
    assert np.allclose(f.hessian[0, 1], 2 * X - np.exp(Y) / X**2)
    assert np.allclose(f.hessian[1, 1], np.exp(Y) / X)


def test_array_on_the_left_and_structural_zeros():
    x, y = variables(X, Y)
    assert np.allclose((X * x).gradient[0], X)
    assert np.allclose((X - x).gradient[0], -1.0)
    assert np.allclose((X / x).hessian[0, 0], 2 / X**2)
    assert (x + 1.0).gradient[1] is None
    assert (0, 1) not in (x * x + y * y).hessian


@pytest.mark.parametrize("exponent", [1, 2, 3, 5, 0.5, -1.7, -2])
def test_powers_to_the_third_derivative(exponent):
    one, zero = np.ones_like(X), np.zeros_like(X)
    terms = (Series(X, one, zero, zero) ** exponent).terms
    factor = 1.0
    for k in range(4):
        assert np.allclose(terms[k], factor * X ** (float(exponent) - k))
        factor *= exponent - k


def test_series_chain_rule_of_third_order():
    one, zero = np.ones_like(X), np.zeros_like(X)
    x = Series(X, one, zero, zero)
    f = np.exp(x**2) * np.log(x)
    # d/dx of exp(x²) ln x, worked out: (2x ln x + 1/x) e, and so on.
    e, ln = np.exp(X**2), np.log(X)
    assert np.allclose(f.terms[1], e * (2 * X * ln + 1 / X))
    assert np.allclose(f.terms[2], e * ((4 * X**2 + 2) * ln + 4 - 1 / X**2))
    third = (8 * X**3 + 12 * X) * ln + 12 * X + (8 * X**2 + 6 - 8 * X**2) / X - 6 / X
    assert np.allclose(f.terms[3], e * (third + 2 / X**3))


def test_exponential_is_the_same_as_a_composed_series():
    log = np.log(X)
    one, zero = np.ones_like(X), np.zeros_like(X)
    fast, slow = Exponential(log), np.exp(Series(log, one, zero, zero))
    for a, b in ((fast**1.7, slow**1.7), (np.log(fast), np.log(slow)), (fast * fast, slow * slow)):
        for p, q in zip(a.terms, b.terms, strict=True):
            assert np.allclose(p, q, atol=1e-14)


def test_positive_part_and_lifted_value():
    (x,) = variables(np.array([-1.0, 0.0, 2.0]))
    square = positive(x) ** 2
    assert np.allclose(square.value, [0, 0, 4])
    assert np.allclose(square.gradient[0], [0, 0, 4])
    # The undeformed state counts as tension.
    assert np.allclose(square.hessian[0, 0], [0, 2, 2])
    lifted = at_least(x, 0.5) ** 2
    assert np.allclose(lifted.value, [0.25, 0.25, 4])
    assert np.allclose(lifted.gradient[0], [1, 1, 4])
