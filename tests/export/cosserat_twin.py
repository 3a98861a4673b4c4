"""The exported model in PyElastica, from the numbers of model.json and nothing else."""

import numpy as np

M, KG, NM2 = 1e-3, 1e3, 1e-6
STEP, LONGEST, STILL = 2e-5, 1.0, 1e-3  # s, s, m/s


def angle_at_rest(elastica, data, pressure, force, gravity):
    """Degrees about y at a pressure (kPa), under a force on the tip (N) and weight (mm/s²)."""
    table, count = data["table"], data["pieces"]

    def at(name):
        return float(np.interp(pressure, table["pressure_kPa"], table[name]))

    masses = KG * np.array(data["masses"]["mass_tonne"][1:])
    centres = M * np.array(data["masses"]["centre_mm"][1:])
    length, offset = M * data["active_length_mm"], M * data["offset_z_mm"]
    area = 4e-4  # of the rotary inertia alone
    rod = elastica.CosseratRod.straight_rod(
        count, np.array([0.0, 0.0, offset]), np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0]),
        length, np.sqrt(area / np.pi), masses[:-1].sum() / length / area,
        youngs_modulus=1e6, shear_modulus=1e6,
    )  # fmt: skip
    bend, pull = at("stiffness_bending_y") * NM2, at("stiffness_stretch")
    for n in range(count - 1):
        rod.bend_matrix[..., n] = np.diag([bend, 10 * bend, 10 * bend])
    for n in range(count):
        rod.shear_matrix[..., n] = np.diag([pull, pull, pull])  # the model has no shear
    rod.rest_kappa[0] = at("rest_bending_y") / M
    rod.rest_sigma[2] = at("rest_stretch")
    # (element, arm from the rod in its frame, force): weights of the pieces, of the tip's end, the
    # force on the tip.
    own = M * np.asarray(gravity, float)
    place = M * np.array([data["end_mm"], data["tip_y_mm"], data["tip_z_mm"]]) - [0, 0, offset]
    element = np.array([*range(count), count - 1, count - 1])
    arms = np.vstack([centres[:-1], centres[-1] + [M * data["end_mm"] / 2, 0.0, 0.0], place])
    forces = np.vstack([np.outer(masses, own), force])

    class Loads(elastica.NoForces):
        """Weight at the centres of the pieces and of the tip's end, the force at the tip."""

        def apply_forces(self, system, time=0.0):
            system.external_forces[:, :-1] += forces[:count].T / 2
            system.external_forces[:, 1:] += forces[:count].T / 2
            system.external_forces[:, -1] += forces[count:].sum(axis=0)

        def apply_torques(self, system, time=0.0):
            # Rows of the directors are y, z and the tangent; the model's order is x, y, z.
            frames = system.director_collection[[2, 0, 1]][..., element]
            turning = np.cross(np.einsum("jin,nj->ni", frames, arms), forces)
            local = np.einsum("ijn,nj->in", system.director_collection[..., element], turning)
            system.external_torques += local[:, :count]
            system.external_torques[:, -1] += local[:, count:].sum(axis=1)

    class Simulator(elastica.BaseSystemCollection, elastica.Constraints, elastica.Forcing,
                    elastica.Damping):  # fmt: skip
        pass

    simulator = Simulator()
    simulator.append(rod)
    simulator.constrain(rod).using(
        elastica.OneEndFixedBC, constrained_position_idx=(0,), constrained_director_idx=(0,)
    )
    simulator.add_forcing_to(rod).using(Loads)
    simulator.dampen(rod).using(
        elastica.AnalyticalLinearDamper, uniform_damping_constant=100.0, time_step=STEP
    )
    simulator.finalize()
    stepper, time = elastica.PositionVerlet(), np.float64(0.0)
    while time < LONGEST:
        for _ in range(500):
            time = stepper.step(simulator, time, STEP)
        if time > 0.1 and np.abs(rod.velocity_collection).max() < STILL:
            break
    tangent = rod.director_collection[2, :, -1]
    # Joints lie between elements: half of the first and of the last are beyond them.
    ends = at("rest_bending_y") / M * length / count
    return float(np.degrees(np.arctan2(-tangent[2], tangent[0]) + ends))
