"""Independent references for bodies that are no cuboid, at 30 digits.

Polyhedra: Werner and Scheeres' sums over edges and triangles with edge dyads, logarithms of (r₁ + r₂ + e)/(r₁ + r₂ - e)
and solid angles after Van Oosterom and Strackee. Cylinders: the potential of their rings by mpmath's elliptic integrals
and quadrature along the axis. Torque and its gradients carry the monopole along and cancel it at high precision.
"""

import mpmath as mp
import numpy as np
from gravity_reference import QUANTITIES

mp.mp.dps = 30


def exact_polyhedron(point, corner, triangle):
    """Force and gradient (mpmath) of a polyhedron on a source at `point`."""
    v = [[mp.mpf(x) for x in c] for c in corner]
    p = [mp.mpf(x) for x in point]
    r = [[c[i] - p[i] for i in range(3)] for c in v]
    size = [mp.sqrt(_dot(x, x)) for x in r]
    force, gamma, volume = mp.zeros(3, 1), mp.zeros(3), mp.mpf(0)
    for a, b, c in triangle:
        normal = _cross(_sub(v[b], v[a]), _sub(v[c], v[a]))
        area = mp.sqrt(_dot(normal, normal))
        normal = [x / area for x in normal]
        volume += _dot(v[a], _cross(v[b], v[c])) / 6
        angle = 2 * mp.atan2(
            _dot(r[a], _cross(r[b], r[c])),
            size[a] * size[b] * size[c]
            + size[a] * _dot(r[b], r[c]) + size[b] * _dot(r[c], r[a]) + size[c] * _dot(r[a], r[b]),
        )  # fmt: skip
        height = _dot(normal, r[a])
        for i in range(3):
            force[i] -= normal[i] * height * angle
            for j in range(3):
                gamma[i, j] -= normal[i] * normal[j] * angle
        for i, j in ((a, b), (b, c), (c, a)):
            edge = _sub(v[j], v[i])
            length = mp.sqrt(_dot(edge, edge))
            log = mp.log((size[i] + size[j] + length) / (size[i] + size[j] - length))
            outward = [x / length for x in _cross(edge, normal)]
            off = _dot(outward, r[i])
            for k in range(3):
                force[k] += normal[k] * off * log
                for m in range(3):
                    gamma[k, m] += normal[k] * outward[m] * log
    return force / volume, gamma / volume


def quantities(point, centre, force, gamma):
    """The six quantities as float arrays, of a source at `point` and a body with its centre of mass at `centre`."""
    arm = mp.matrix([mp.mpf(x) - mp.mpf(c) for x, c in zip(point, centre, strict=True)])
    cross_r, cross_f = _matrix(arm), _matrix(force)
    gamma_ang = -cross_f - gamma * cross_r
    results = (force, gamma, cross_r * force, cross_f + cross_r * gamma, gamma_ang, cross_r * gamma_ang)
    return {
        name: np.array(value.tolist(), dtype=float).reshape((3,) if value.cols == 1 else (3, 3))
        for name, value in zip(QUANTITIES, results, strict=True)
    }


def exact_centre(corner, triangle):
    """Centre of mass of a polyhedron (mpmath)."""
    volume, first = mp.mpf(0), [mp.mpf(0)] * 3
    for row in triangle:
        a, b, c = ([mp.mpf(x) for x in corner[i]] for i in row)
        six = _dot(a, _cross(b, c))
        volume += six / 6
        first = [f + six * (x + y + z) / 24 for f, x, y, z in zip(first, a, b, c, strict=True)]
    return [f / volume for f in first]


def exact_cylinder(point, radius, low, high):
    """Force and gradient (mpmath) of a cylinder about z between `low` and `high`, as integrals over z of its disks.

    The potential of a homogeneous disk obeys ``∂U/∂z`` = minus its solid angle; here all is integrated over the body in
    the plainest form, force and gradient of a point, in cylindrical coordinates centred on the axis.
    """
    x, y, z = (mp.mpf(c) for c in point)
    a, b1, b2 = mp.mpf(radius), mp.mpf(low), mp.mpf(high)
    rho = mp.sqrt(x * x + y * y)
    volume = mp.pi * a * a * (b2 - b1)

    def inner(phi, what):
        """Integral over the height of the lateral surface, or over the caps, at one azimuth from the point's."""
        c, s = mp.cos(phi), mp.sin(phi)
        u, w = a * c - rho, a * s
        square = u * u + w * w
        z1, z2 = b1 - z, b2 - z
        r1, r2 = mp.sqrt(square + z1 * z1), mp.sqrt(square + z2 * z2)
        log = mp.asinh(z2 / mp.sqrt(square)) - mp.asinh(z1 / mp.sqrt(square))
        cube = (z2 / r2 - z1 / r1) / square
        turn = a * a - a * rho * c
        return {
            "fr": a * c * log,
            "fz": turn * ((r2 - abs(z2)) - (r1 - abs(z1))) / square,
            "grr": -a * c * u * cube,
            "gff": -a * s * a * s * cube,
            "gzz": turn * ((mp.sign(z1) - z1 / r1) - (mp.sign(z2) - z2 / r2)) / square,
            "grz": a * c * (1 / r2 - 1 / r1),
        }[what]

    with mp.workdps(18):
        return _by_quadrature(inner, a, rho, x, y, max(b1 - z, z - b2, 0), volume)


def _by_quadrature(inner, a, rho, x, y, beyond, volume):
    nearest = mp.sqrt((a - rho) ** 2 + beyond**2) / a
    cuts = [mp.mpf(0)]
    step = min(nearest, mp.pi)
    while cuts[-1] < mp.pi:
        cuts.append(min(cuts[-1] + step, mp.pi))
        step *= 2
    found = {
        k: 2 * mp.quad(lambda phi, k=k: inner(phi, k), cuts) / volume for k in ("fr", "fz", "grr", "gff", "gzz", "grz")
    }
    c, s = (x / rho, y / rho) if rho else (mp.mpf(1), mp.mpf(0))
    turn = mp.matrix([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    gamma = mp.matrix([[found["grr"], 0, found["grz"]], [0, found["gff"], 0], [found["grz"], 0, found["gzz"]]])
    return turn * mp.matrix([found["fr"], 0, found["fz"]]), turn * gamma * turn.T


def _dot(a, b):
    return sum(x * y for x, y in zip(a, b, strict=True))


def _sub(a, b):
    return [x - y for x, y in zip(a, b, strict=True)]


def _cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def _matrix(v):
    return mp.matrix([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
