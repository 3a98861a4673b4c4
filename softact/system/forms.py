"""The weak forms, in UFL. Each function returns forms that belong to no particular mesh.

Notation: u displacement, p hydrostatic pressure (positive in tension), F = I + grad u, J = det F,
E Green strain, S second Piola-Kirchhoff stress, N outward normal of the undeformed solid. Strain
and stress are written as Voigt vectors in the order 11, 22, 33, 12, 13, 23; shear strains carry
the factor two.

geometry: degree of the tetrahedra's own shape, 1 straight and 2 curved. degree: that of the
displacement.
"""

from __future__ import annotations

from typing import Any

import ufl
from ufl.core.expr import Expr

from softact import compat

QUADRATURE_DEGREE = 2  # four points per tetrahedron, as C3D10 has in Abaqus and CalculiX
LAYER_STATES = 3  # from which a layer's stress is extrapolated
FACET_DEGREE = 4  # integrates the volume enclosed by quadratic triangles exactly


def deformation_gradient(u: Expr) -> Expr:
    """F = I + grad u."""
    return ufl.Identity(3) + ufl.grad(u)


def green_strain_rate(u: Expr, v: Expr) -> Expr:
    """Voigt vector of the derivative of the Green strain in the direction v: sym(Fᵀ grad v)."""
    e = ufl.sym(deformation_gradient(u).T * ufl.grad(v))
    return ufl.as_vector([e[0, 0], e[1, 1], e[2, 2], 2 * e[0, 1], 2 * e[0, 2], 2 * e[1, 2]])


def _symmetric(s: Expr) -> Expr:
    return ufl.as_tensor([[s[0], s[3], s[4]], [s[3], s[1], s[5]], [s[4], s[5], s[2]]])


def _dx() -> ufl.Measure:
    return ufl.dx(metadata={"quadrature_degree": QUADRATURE_DEGREE})


def _ds(degree: int) -> ufl.Measure:
    return ufl.ds(metadata={"quadrature_degree": degree})


def _space(geometry: int, element: Any) -> ufl.FunctionSpace:
    return ufl.FunctionSpace(compat.ufl_mesh(geometry), element)


def _displacement_space(geometry: int, degree: int) -> ufl.FunctionSpace:
    return _space(geometry, compat.lagrange(degree, (3,)))


def solid(geometry: int, degree: int, pressure_degree: int | None) -> tuple[ufl.Form]:
    """Stress divergence and incompressibility of a solid: the residual; its tangent is
    ``solid_tangent`` of ``_assembly.c``.

    Π = ∫ W̄(C) + p (J − 1) − U*(p) dX; the stress S = 2 ∂W̄/∂C comes as values at the
    quadrature points, so that every law of the library uses this one form.
    U* is the complementary volumetric energy, whose derivative J(p) − 1 inverts p = U'(J):
    J(p) = p/κ + √(1 + β (p/κ)²) with β = 0 for U = κ/2 (J − 1)² and β = 1 for
    U = κ/2 ((J² − 1)/2 − ln J). Left to S, the difference of the two would not be convex.
    Without a ``pressure_degree`` there is no p, and S holds the volumetric part as well.

    Coefficients: unknowns, S (6). Constants, with a pressure: 1/κ, β.
    """
    elements = [compat.lagrange(degree, (3,))]
    if pressure_degree is not None:
        elements.append(compat.lagrange(pressure_degree, (), pressure_degree == 0))
    space = _space(geometry, compat.mixed(*elements))
    w, test = ufl.Coefficient(space), ufl.TestFunction(space)
    stress = ufl.Coefficient(_space(geometry, compat.quadrature_element(QUADRATURE_DEGREE, 6)))
    if pressure_degree is None:
        return (ufl.dot(stress, green_strain_rate(w, test)) * _dx(),)
    (u, p), (v, q) = ufl.split(w), ufl.split(test)
    residual = ufl.dot(stress, green_strain_rate(u, v)) * _dx()
    compliance, logarithmic = (ufl.Constant(space.ufl_domain()) for _ in range(2))
    swelling = compliance * p
    grown = swelling + ufl.sqrt(1 + logarithmic * swelling**2)
    residual += ufl.derivative(p * ufl.det(deformation_gradient(u)) * _dx(), w, test)
    return (residual - grown * q * _dx(),)


def cavity(geometry: int, degree: int) -> tuple[ufl.Form, ufl.Form, ufl.Form]:
    """Volume that a cavity's walls enclose and the follower pressure: (volume, force, tangent).

    V(u) = −⅓ ∫ (X + u) · cof(F) N dA over the walls; N points out of the solid, so into the
    cavity. A wall in a plane through the origin adds nothing, so the part of the boundary that
    lies in a symmetry plane may be left out. Force and tangent are the derivatives of −p V, so
    the tangent is exact and symmetric. Coefficient (all): u. Constant (force, tangent): p.
    """
    space = _displacement_space(geometry, degree)
    mesh = space.ufl_domain()
    u, pressure = ufl.Coefficient(space), ufl.Constant(mesh)
    position = ufl.SpatialCoordinate(mesh) + u
    area = ufl.cofac(deformation_gradient(u)) * ufl.FacetNormal(mesh)
    ds = _ds(FACET_DEGREE)
    volume = -ufl.dot(position, area) / 3
    test, trial = ufl.TestFunction(space), ufl.TrialFunction(space)
    force = ufl.derivative(-pressure * volume * ds, u, test)
    return volume * ds, force, ufl.derivative(force, u, trial)


def surface_pressure(geometry: int, degree: int) -> tuple[ufl.Form, ufl.Form]:
    """Follower pressure on a surface that need not enclose anything: (force, tangent).

    The pressure −p cof(F) N per undeformed area pushes against the normal N out of the solid. On
    an open surface it has no potential: the exact tangent is not symmetric along the free edge, and
    the symmetric part is given, which costs Newton iterations but no accuracy.
    Coefficient (both): u. Constant (both): p.
    """
    space = _displacement_space(geometry, degree)
    mesh = space.ufl_domain()
    u, pressure = ufl.Coefficient(space), ufl.Constant(mesh)
    test, trial = ufl.TestFunction(space), ufl.TrialFunction(space)
    normal = ufl.FacetNormal(mesh)

    def pull(f: Expr, v: Expr) -> Expr:
        return pressure * ufl.dot(ufl.cofac(f) * normal, v)

    ds = _ds(FACET_DEGREE)
    force = pull(deformation_gradient(u), test) * ds
    exact = ufl.derivative(force, u, trial)
    return force, 0.5 * (exact + ufl.adjoint(exact))


def layer(geometry: int, degree: int) -> tuple[ufl.Form, ufl.Form, ufl.Form]:
    """Thin elastic layer bonded to a surface: (energy, residual, tangent).

    Plane-stress St. Venant-Kirchhoff membrane on the tangential Green strain E:
    Π = ∫ A/2 ((1 − ν) E : E + ν (tr E)²) dA with A = E_young t / (1 − ν²).
    Coefficients: energy and residual (u); tangent (u and LAYER_STATES others, v₁, …): the geometric
    stiffness takes the stress from the strain Σ wₖ E(vₖ) + l E'(v₁)(u − v₁).
    Constants: A, ν; tangent also w₁, … and l.
    """
    space = _displacement_space(geometry, degree)
    mesh = space.ufl_domain()
    u, *states = (ufl.Coefficient(space) for _ in range(1 + LAYER_STATES))
    stiffness, poisson, *weights = (ufl.Constant(mesh) for _ in range(2 + LAYER_STATES))
    linearised = ufl.Constant(mesh)
    normal = ufl.FacetNormal(mesh)
    plane = ufl.Identity(3) - ufl.outer(normal, normal)
    test, trial = ufl.TestFunction(space), ufl.TrialFunction(space)

    def tangential(strain: Expr) -> Expr:
        return plane * strain * plane

    def strain(u: Expr) -> Expr:
        f = deformation_gradient(u)
        return tangential((f.T * f - ufl.Identity(3)) / 2)

    def strain_rate(u: Expr, v: Expr) -> Expr:
        return tangential(ufl.sym(deformation_gradient(u).T * ufl.grad(v)))

    def stress(e: Expr) -> Expr:
        return stiffness * ((1 - poisson) * e + poisson * ufl.tr(e) * plane)

    ds = _ds(QUADRATURE_DEGREE)
    energy = ufl.inner(stress(strain(u)), strain(u)) / 2 * ds
    residual = ufl.inner(stress(strain(u)), strain_rate(u, test)) * ds
    carried = linearised * strain_rate(states[0], u - states[0])
    for weight, v in zip(weights, states, strict=True):
        carried += weight * strain(v)
    second = tangential(ufl.sym(ufl.grad(trial).T * ufl.grad(test)))
    tangent = (
        ufl.inner(stress(strain_rate(u, trial)), strain_rate(u, test))
        + ufl.inner(stress(carried), second)
    ) * ds
    return energy, residual, tangent


def body_force(geometry: int, degree: int) -> tuple[ufl.Form]:
    """Work of a body force per undeformed volume: linear form; constant: the force (3)."""
    space = _displacement_space(geometry, degree)
    force = ufl.Constant(space.ufl_domain(), shape=(3,))
    return (ufl.dot(force, ufl.TestFunction(space)) * _dx(),)


def inertia(geometry: int, degree: int) -> tuple[ufl.Form, ufl.Form]:
    """Force of an acceleration: (force, tangent). Coefficient of the force: displacement from
    where the body would be without force; constant (both): density over the squared time step."""
    space = _displacement_space(geometry, degree)
    away, factor = ufl.Coefficient(space), ufl.Constant(space.ufl_domain())
    test, trial = ufl.TestFunction(space), ufl.TrialFunction(space)
    dx = ufl.dx(metadata={"quadrature_degree": 2 * degree})
    return factor * ufl.dot(away, test) * dx, factor * ufl.dot(trial, test) * dx


def surface_force(geometry: int, degree: int) -> tuple[ufl.Form]:
    """Work of a dead force per undeformed area: linear form; constant: the force (3)."""
    space = _displacement_space(geometry, degree)
    force = ufl.Constant(space.ufl_domain(), shape=(3,))
    return (ufl.dot(force, ufl.TestFunction(space)) * _ds(QUADRATURE_DEGREE),)
