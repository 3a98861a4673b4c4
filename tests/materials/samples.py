"""A material of each law, and random states of deformation, for the tests of the laws."""

import numpy as np

from softact.materials import LAWS, Law, load_card

SAMPLES: dict[str, Law] = {
    "neo_hookean": LAWS["neo_hookean"].of(c10=0.14),
    "mooney_rivlin_2": LAWS["mooney_rivlin"].of(c10=0.11, c01=0.03),
    "mooney_rivlin_9": LAWS["mooney_rivlin"].of(
        c10=0.1, c01=0.03, c20=0.01, c11=0.02, c02=0.01, c30=0.002, c21=0.001, c12=0.003, c03=0.001
    ),
    "yeoh": LAWS["yeoh"].of(c10=0.11, c20=0.02, c30=0.003),
    "reduced_polynomial": LAWS["reduced_polynomial"].of(
        c10=0.1, c20=0.02, c30=3e-3, c40=1e-3, c50=1e-4, c60=1e-5
    ),
    "ogden_1": LAWS["ogden"].of(mu=[0.3], alpha=[2.4]),
    "ogden_3": load_card("ecoflex-00-30"),
    "ogden_classic": LAWS["ogden"].of(
        convention="classic", mu=[0.63, 0.0012, -0.01], alpha=[1.3, 5.0, -2.0]
    ),
    "ogden_6": LAWS["ogden"].of(
        mu=[0.1, 0.02, 0.03, 0.01, 0.005, 0.002], alpha=[1.5, 4.0, -2.0, 0.5, -0.7, 6.0]
    ),
    "arruda_boyce": LAWS["arruda_boyce"].of(mu=0.2, lambda_m=3.0),
    "van_der_waals": LAWS["van_der_waals"].of(mu=0.3, lambda_m=8.0, a=0.2, beta=0.1),
    "gent": LAWS["gent"].of(mu=0.3, jm=60.0),
    "fung": LAWS["fung"].of(mu=0.3, b=0.4),
    "linear": load_card("pet"),
    "holzapfel": LAWS["holzapfel"].of(c10=0.3, k1=0.6, k2=0.4, kappa=0.1, angle=30.0),
    "holzapfel_one": LAWS["holzapfel"].of(c10=0.3, k1=0.6, k2=0.0, angle=20.0, families=1),
}

VOIGT = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))


def tensor(components: np.ndarray) -> np.ndarray:
    """Symmetric tensors (n,3,3) from Voigt components (n,6)."""
    result = np.empty((len(components), 3, 3))
    for a, (i, j) in enumerate(VOIGT):
        result[:, i, j] = result[:, j, i] = components[:, a]
    return result


def deformations(count: int, size: float = 0.25, seed: int = 3) -> np.ndarray:
    """Random deformation gradients (count, 3, 3) with a determinant between 0.3 and 3."""
    rng = np.random.default_rng(seed)
    F = np.eye(3) + size * rng.standard_normal((20 * count, 3, 3))
    J = np.linalg.det(F)
    stretch = np.linalg.svd(F, compute_uv=False)[:, 0] * np.cbrt(1.0 / np.abs(J))
    return F[(J > 0.3) & (J < 3.0) & (stretch < 2.2)][:count]


def cauchy_green(F: np.ndarray) -> np.ndarray:
    """C = FᵀF."""
    return np.swapaxes(F, 1, 2) @ F


def rotations(count: int, seed: int = 5) -> np.ndarray:
    """Random rotations (count, 3, 3)."""
    rng = np.random.default_rng(seed)
    Q, R = np.linalg.qr(rng.standard_normal((count, 3, 3)))
    Q = Q * np.sign(np.diagonal(R, axis1=1, axis2=2))[:, None, :]
    return Q * np.linalg.det(Q)[:, None, None]


def fibres_of(law: Law, count: int) -> np.ndarray | None:
    """Directions in a plane that is not one of the coordinate planes."""
    if not law.anisotropic:
        return None
    axis = np.tile([1.0, 0.2, 0.0], (count, 1))
    return law.fibre_directions(axis, np.tile([0.1, 0.3, 1.0], (count, 1)))
