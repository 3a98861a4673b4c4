"""Homogeneous and spherical states of an incompressible Neo-Hookean material with Maxwell elements.

With αᵢ = S − hᵢ of each element, α̇ = (S − α)/τ, an ordinary differential equation that is solved to
1e-10: nothing of it is shared with the solver, which goes by increments.
"""

import numpy as np
import scipy.integrate
import scipy.optimize

C10 = 0.1  # MPa


def deviators(along, across):
    """Isochoric S = 2 C10 (I − I1/3 C⁻¹) (2, n): along a direction and across it."""
    first = along**2 + 2 * across**2
    return np.array([2 * C10 * (1 - first / (3 * s**2)) for s in (along, across)])


def difference(along, across, prony, alpha):
    """Cauchy stress along less that across, MPa; alpha: (k, 2, n)."""
    s = deviators(along, across)
    whole = prony.elastic * s + np.einsum("k,kin->in", prony.shares, s - alpha)
    return along**2 * whole[0] - across**2 * whole[1]


def _run(prony, rates, points, times):
    """alpha (k, 2, n) at the times."""
    count = len(prony.times)

    def change(t, flat):
        alpha = flat.reshape(count, 2, points)
        return ((rates(t, alpha) - alpha) / prony.times[:, None, None]).ravel()

    start = np.zeros(count * 2 * points)
    found = scipy.integrate.solve_ivp(
        change, (0.0, times[-1]), start, "LSODA", times, rtol=1e-9, atol=1e-11, max_step=0.05
    )
    return found.y.T.reshape(-1, count, 2, points)


def force_of_stretch(prony, stretch, times):
    """Nominal stress (MPa) at the times under a stretch(t)."""

    def s(t, alpha):
        return deviators(np.array([stretch(t)]), np.array([stretch(t) ** -0.5]))

    alphas = _run(prony, s, 1, times)
    return [
        difference(np.array([stretch(t)]), np.array([stretch(t) ** -0.5]), prony, a)[0] / stretch(t)
        for t, a in zip(times, alphas, strict=True)
    ]


def stretch_of_force(prony, nominal, times):
    """Stretch at the times under a nominal stress(t), MPa."""

    def stretch(t, alpha):
        def off(lam):
            one = np.array([lam])
            return difference(one, one**-0.5, prony, alpha)[0] / lam - nominal(t)

        return scipy.optimize.brentq(off, 0.5, 3.0, xtol=1e-13)

    def s(t, alpha):
        lam = np.array([stretch(t, alpha)])
        return deviators(lam, lam**-0.5)

    alphas = _run(prony, s, 1, times)
    return [stretch(t, a) for t, a in zip(times, alphas, strict=True)]


def sphere_of_pressure(prony, pressure, inner, outer, times):
    """Stretch of the inner surface at the times under an inner pressure(t), MPa.

    p = ∫ 2 (σθ − σr) dr/r with r³ = R³ + a³ − A³, by Gauss's rule over R.
    """
    nodes, weights = np.polynomial.legendre.leggauss(8)
    radius = inner + (outer - inner) * (nodes + 1) / 2
    share = weights * (outer - inner) / 2

    def stretches(lam):
        r3 = radius**3 + (lam**3 - 1) * inner**3
        return np.cbrt(r3) / radius, r3

    def balance(lam, alpha):
        hoop, r3 = stretches(lam)
        stress = -difference(hoop**-2, hoop, prony, alpha)
        return float(share @ (2 * stress * radius**2 / r3))

    def found(t, alpha):
        return scipy.optimize.brentq(
            lambda lam: balance(lam, alpha) - pressure(t), 0.9, 1.38, xtol=1e-13
        )

    def s(t, alpha):
        hoop, _ = stretches(found(t, alpha))
        return deviators(hoop**-2, hoop)

    alphas = _run(prony, s, len(nodes), times)
    return [found(t, a) for t, a in zip(times, alphas, strict=True)]
