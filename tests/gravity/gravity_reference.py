"""Independent references for the cuboid field: corner sums at 50 digits, and quadrature over the faces."""

import mpmath as mp
import numpy as np

QUANTITIES = ("force", "gamma_lin", "torque", "omega_lin", "gamma_ang", "omega_ang")
AXIS_PERMUTATION = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])


def cross_matrix(v):
    x, y, z = v
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def exact_field(point, sides, digits=50):
    """The six quantities of the kernel as float arrays, from the definitions and a corner sum at `digits` digits.

    The corner sum is the classical one of the right rectangular prism (Nagy, Papp and Benedek 2000), with principal
    arctangents of single corners. It is singular on face planes and edge lines, where the field is not: the point is
    moved by 1e-35 of the sides. Torque and its gradients carry the monopole along and cancel it at high precision.
    """
    with mp.workdps(digits):
        side = [mp.mpf(float(s)) for s in sides]
        volume = side[0] * side[1] * side[2]
        position = [mp.mpf(float(p)) + (n + 1) * mp.mpf(10) ** -35 * side[n] for n, p in enumerate(point)]
        force, gamma = mp.zeros(3, 1), mp.zeros(3)
        for signs in np.ndindex(2, 2, 2):
            corner = [(2 * s - 1) * side[n] / 2 - position[n] for n, s in enumerate(signs)]
            sign = (-1) ** (1 + sum(signs))
            r = mp.sqrt(sum(c * c for c in corner))
            for n in range(3):
                a, b = (n + 1) % 3, (n + 2) % 3
                # ln(c + r), written without cancellation for c < 0
                c = corner[n]
                log = mp.log(c + r) if c > 0 else mp.log(corner[a] ** 2 + corner[b] ** 2) - mp.log(r - c)
                angle = mp.atan(corner[a] * corner[b] / (c * r))
                force[a] += sign * corner[b] * log
                force[b] += sign * corner[a] * log
                force[n] -= sign * c * angle
                gamma[n, n] -= sign * angle
                gamma[a, b] += sign * log
                gamma[b, a] += sign * log
        force, gamma = force / volume, gamma / volume
        radius = mp.matrix(position)
        cross_r, cross_f = _mp_cross(radius), _mp_cross(force)
        gamma_ang = -cross_f - gamma * cross_r
        results = (force, gamma, cross_r * force, cross_f + cross_r * gamma, gamma_ang, cross_r * gamma_ang)
        return {
            name: np.array(value.tolist(), dtype=float).reshape((3,) if value.cols == 1 else (3, 3))
            for name, value in zip(QUANTITIES, results, strict=True)
        }


def exact_fields(points, sides, digits=50):
    """`exact_field` of several points, stacked."""
    rows = [exact_field(point, sides, digits) for point in points]
    return {name: np.array([row[name] for row in rows]) for name in QUANTITIES}


def face_quadrature(point, sides):
    """Fx and Γxx as numerical integrals of 1/r and -d/r³ over the two faces normal to x (Gauss's theorem)."""
    with mp.workdps(17):
        half = [mp.mpf(float(s)) / 2 for s in sides]
        px, py, pz = (mp.mpf(float(p)) for p in point)
        force = gamma = mp.mpf(0)
        for sign in (-1, 1):
            d = sign * half[0] - px

            def radius(y, z, d=d):
                return mp.sqrt(d * d + (y - py) ** 2 + (z - pz) ** 2)

            bounds = ([-half[1], half[1]], [-half[2], half[2]])
            force += sign * mp.quad(lambda y, z, r=radius: 1 / r(y, z), *bounds)
            gamma -= sign * mp.quad(lambda y, z, r=radius, d=d: d / r(y, z) ** 3, *bounds)
        volume = 8 * half[0] * half[1] * half[2]
        return float(force / volume), float(gamma / volume)


def relative_errors(computed, exact, points):
    """Largest error of each quantity, [n], relative to its largest element at the same point.

    The torque of a cube vanishes on its symmetry axes: it is judged against the larger of itself and a tenth of
    distance times omega_lin, its change over a tenth of the distance.
    """
    errors = {}
    for name in QUANTITIES:
        axes = tuple(range(1, exact[name].ndim))
        scale = np.abs(exact[name]).max(axis=axes)
        if name == "torque":
            distance = np.linalg.norm(points, axis=1)
            scale = np.maximum(scale, 0.1 * distance * np.abs(exact["omega_lin"]).max(axis=(1, 2)))
        errors[name] = np.abs(getattr(computed, name) - exact[name]).max(axis=axes) / scale
    return errors


def _mp_cross(v):
    return mp.matrix([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
