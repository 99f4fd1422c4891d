"""Worst relative errors of the kernel by shape and distance, against corner sums at 50 digits.

``python tests/gravity/accuracy_table.py`` prints the tables of docs/reference/accuracy.md.
"""

from functools import lru_cache

import numpy as np
from gravity_reference import QUANTITIES, exact_fields, relative_errors

from tedm_cli.gravity.kernel import cuboid_field, cuboid_force_gradient

CUBE = np.full(3, 0.046)
SHAPES = {
    "cube": CUBE,
    "slab": np.array([0.046, 0.046, 0.0046]),
    "brick": np.array([0.02, 0.046, 0.03]),
    "rod": np.array([0.005, 0.046, 0.006]),
    "near cube": np.array([0.046, 0.046, 0.046 * (1 + 1e-7)]),
}
# distance from the centre over half the body diagonal
BANDS = ((0.6, 1.7), (1.7, 2.1), (2.1, 2.8), (2.8, 4.0), (4.0, 8.0), (8.0, 20.0), (20.0, 60.0), (60.0, 1200.0))
POINTS_PER_BAND = 14
SURFACE = "surface and prolonged faces"
COLUMNS = (*QUANTITIES, "force alone", "gamma_lin alone")


def random_points(sides, lower, upper, count, rng):
    directions = rng.normal(size=(4 * count, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    ratio = np.exp(rng.uniform(np.log(lower), np.log(upper), size=4 * count))
    points = directions * ratio[:, None] * np.linalg.norm(sides) / 2
    return points[(np.abs(points) > sides / 2).any(axis=1)][:count]


def surface_points(sides, gap, rng):
    """Points at up to `gap` from faces, edges and corners."""
    half = sides / 2
    points = []
    for outside in np.ndindex(2, 2, 2):
        if any(outside):
            inner = rng.uniform(-1, 1, 3) * half
            outer = rng.choice([-1.0, 1.0], 3) * (half + gap * rng.uniform(0.1, 1.0, 3))
            points.append(np.where(outside, outer, inner))
    return np.array(points)


def extension_points(sides):
    """Points on the planes of faces, the lines of edges, and both prolonged, outside the body."""
    x, y, z = sides / 2
    return np.array(
        [
            [x, 1.5 * y, 0.3 * z],
            [-x, 0.2 * y, 4.0 * z],
            [x, y, 1.1 * z],
            [x, -y, -3.0 * z],
            [3.0 * x, y, z],
            [-1.01 * x, -y, z],
            [x, 5.0 * y, -z],
            [0.0, 1.3 * y, 0.0],
            [0.0, 0.0, -2.0 * z],
            [x, 40.0 * y, z],
            [1.5 * x, 1.5 * y, 1.5 * z],
        ]
    )


@lru_cache
def errors_by_band(shape):
    """{band: (points [n, 3], {column: errors [n]})} of one shape."""
    sides = SHAPES[shape]
    rng = np.random.default_rng(20040501)
    sets = {f"{a:g} to {b:g}": random_points(sides, a, b, POINTS_PER_BAND, rng) for a, b in BANDS}
    near = [surface_points(sides, gap * sides.max(), rng) for gap in (1e-9, 1e-5, 1e-2)]
    sets[SURFACE] = np.concatenate([*near, extension_points(sides)])
    table = {}
    for band, points in sets.items():
        exact = exact_fields(points, sides)
        errors = relative_errors(cuboid_field(points, sides), exact, points)
        for name, value in zip(("force", "gamma_lin"), cuboid_force_gradient(points, sides), strict=True):
            axes = tuple(range(1, value.ndim))
            scale = np.abs(exact[name]).max(axis=axes)
            errors[f"{name} alone"] = np.abs(value - exact[name]).max(axis=axes) / scale
        table[band] = (points, errors)
    return table


def main():
    for title, shapes in (
        ("Cube and near cube (one part in 1e7 longer)", ("cube", "near cube")),
        ("Brick, 20 × 46 × 30", ("brick",)),
        ("Slab, 10 × 10 × 1, and rod, 5 × 46 × 6", ("slab", "rod")),
    ):
        tables = [errors_by_band(shape) for shape in shapes]
        count = sum(len(points) for table in tables for points, _ in table.values())
        print(f"### {title}: {count} points\n")
        print(f"| distance / half diagonal | {' | '.join(COLUMNS)} |\n|---{'|---' * len(COLUMNS)}|")
        for band in tables[0]:
            worst = (max(table[band][1][name].max() for table in tables) for name in COLUMNS)
            print(f"| {band} | {' | '.join(f'{value:.0e}' for value in worst)} |")
        print()


if __name__ == "__main__":
    main()
