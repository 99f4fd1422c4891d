"""Self-gravity of a mass distribution on one test mass: sums over point sources, normalised as accelerations."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import ArrayLike

from tedm_cli.arrays import FloatArray, IndexArray, IntArray
from tedm_cli.errors import PhysicsError
from tedm_cli.gravity.constants import G_CODATA_2018
from tedm_cli.gravity.kernel import BodyField
from tedm_cli.gravity.testmass import TestMass, to_test_mass_frame

_BLOCK_SOURCES = 1 << 14
_SHAPES = {f.name: (3,) if f.name in ("force", "torque") else (3, 3) for f in fields(BodyField)}

#: What pulls at a test mass, as sensitivity.h5 names it.
STRUCTURE, OTHER_TEST_MASS, COMPENSATION = SOURCES = ("structure", "other test mass", "compensation masses")


@dataclass(frozen=True, eq=False, kw_only=True)
class SelfGravity:
    """Self-gravity on a test mass, in its frame, normalised by its mass and tensor of inertia.

    Contributions of separate source sets (structure, other test mass, compensation masses) add with ``+``.
    """

    acceleration: FloatArray
    """[3], ``F/M``, m/s²."""
    angular_acceleration: FloatArray
    """[3], ``I⁻¹ T``, rad/s²."""
    gamma_lin: FloatArray
    """[3, 3], acceleration per displacement of the test mass, 1/s²."""
    omega_lin: FloatArray
    """[3, 3], angular acceleration per displacement of the test mass, rad/s² per m (1/(m s²))."""
    gamma_ang: FloatArray
    """[3, 3], acceleration per rotation of the test mass, m/s² per rad."""
    omega_ang: FloatArray
    """[3, 3], angular acceleration per rotation of the test mass, 1/s²."""

    def __add__(self, other: SelfGravity) -> SelfGravity:
        return SelfGravity(**{f.name: getattr(self, f.name) + getattr(other, f.name) for f in fields(self)})


def self_gravity(
    points: ArrayLike,
    masses: ArrayLike,
    test_mass: TestMass,
    *,
    G: float = G_CODATA_2018,
    node_ids: Sequence[int] | IntArray | None = None,
) -> SelfGravity:
    """Sum the field of point sources on a test mass (Montemurro 2004, chapters 5 and 6, corrected).

    Parameters
    ----------
    points : [n, 3], positions of the sources in the basic frame [m].
    masses : [n], masses of the sources [kg]; massless sources are skipped wherever they are.
    test_mass : the body acted upon.
    G : gravitational constant [m³ kg⁻¹ s⁻²].
    node_ids : [n], names of the sources in error messages (their indices by default).

    Returns
    -------
    SelfGravity, in the frame of the test mass.

    Raises
    ------
    PhysicsError
        If a source with mass is not finite, or inside or on the test mass; names the node and the test mass.

    Examples
    --------
    A kilogram at 0.2 m on each side pulls nowhere, but makes the test mass unstable along the line between them:

    >>> import numpy as np
    >>> from tedm_cli.gravity.field import self_gravity
    >>> from tedm_cli.gravity.testmass import TestMass
    >>> tm = TestMass(name="TM1", position_m=np.zeros(3), side_m=np.full(3, 0.046), mass_kg=1.96)
    >>> pair = self_gravity([[0.2, 0.0, 0.0], [-0.2, 0.0, 0.0]], [1.0, 1.0], tm)
    >>> bool(np.abs(pair.acceleration).max() < 1e-24)
    True
    >>> print("%.4e, %.4e 1/s^2" % (pair.gamma_lin[0, 0], pair.gamma_lin[1, 1]))
    3.3351e-08, -1.6676e-08 1/s^2
    """
    total = FieldSum()
    for _, position, mass in massive_blocks(points, masses, test_mass, node_ids):
        total.add(test_mass.body.field(position), mass)
    return total.result(test_mass, G)


class FieldSum:
    """Sums of a field over sources, block by block: by groups and pairwise inside a block, exact between the blocks."""

    def __init__(self) -> None:
        self._partial: dict[str, list[FloatArray]] = {name: [] for name in _SHAPES}

    def add(self, field: BodyField, mass: FloatArray) -> None:
        """Add n sources of `mass` [n], kg."""
        # The compiled loops are loaded here: importing the compiler takes longer than all the rest of the room.
        from tedm_cli.gravity.assembly import GROUP, put_sums

        for name, partial in self._partial.items():
            values = getattr(field, name).reshape(mass.size, -1)
            values.flags.writeable = False  # as most are: one compilation
            sums = np.empty((values.shape[1], -(-mass.size // GROUP)))
            put_sums(values, mass, sums)
            # summation over a contiguous axis is pairwise
            partial.append(sums.sum(axis=1))

    def result(self, test_mass: TestMass, G: float) -> SelfGravity:
        """The sums times G, normalised by mass and tensor of inertia."""
        total = {
            name: G * np.array([math.fsum(column) for column in np.reshape(blocks, (len(blocks), -1)).T]).reshape(shape)
            if (blocks := self._partial[name])
            else np.zeros(shape)
            for name, shape in _SHAPES.items()
        }
        return _normalised(total, test_mass)


def self_gravity_by_source(
    points: ArrayLike, masses: ArrayLike, test_mass: TestMass, *, G: float = G_CODATA_2018
) -> SelfGravity:
    """What each point source contributes to `self_gravity`, with the same arguments and errors.

    Returns
    -------
    SelfGravity whose arrays have a leading axis over the n sources; zeros where a source has no mass.
    """
    count = np.shape(masses)[0]
    total = {name: np.zeros((count, *shape)) for name, shape in _SHAPES.items()}
    for index, position, mass in massive_blocks(points, masses, test_mass, None):
        block = test_mass.body.field(position)
        for name, shape in _SHAPES.items():
            total[name][index] = (G * mass).reshape(-1, *(1 for _ in shape)) * getattr(block, name)
    return _normalised(total, test_mass)


def _normalised(field: dict[str, FloatArray], test_mass: TestMass) -> SelfGravity:
    """From the quantities of `BodyField` summed with G m, [..., 3] and [..., 3, 3]."""
    return SelfGravity(
        acceleration=field["force"],
        angular_acceleration=test_mass.per_inertia(field["torque"]),
        gamma_lin=field["gamma_lin"],
        omega_lin=test_mass.per_inertia(field["omega_lin"], -2),
        gamma_ang=field["gamma_ang"],
        omega_ang=test_mass.per_inertia(field["omega_ang"], -2),
    )


def massive_blocks(
    points: ArrayLike,
    masses: ArrayLike,
    test_mass: TestMass,
    node_ids: Sequence[int] | IntArray | None,
) -> Iterator[tuple[IndexArray, FloatArray, FloatArray]]:
    """Iterate over the sources that have mass, in blocks of bounded size.

    Yields
    ------
    index : [b], indices of the sources of the block.
    position : [b, 3], their positions in the frame of the test mass [m].
    mass : [b], their masses [kg].

    Raises
    ------
    PhysicsError
        If such a source is not finite, or inside or on the test mass; names the node and the test mass.
    """
    points = np.asarray(points, dtype=np.float64).reshape(-1, 3)
    masses = np.asarray(masses, dtype=np.float64)
    if masses.shape != points.shape[:1]:
        raise ValueError(f"{points.shape[0]} sources but masses of shape {masses.shape}")
    if not np.isfinite(masses).all():
        node = _node_name(int(np.argmin(np.isfinite(masses))), node_ids)
        raise PhysicsError(f"mass of {node} is not finite")
    massive = np.flatnonzero(masses)
    for start in range(0, massive.size, _BLOCK_SOURCES):
        index = massive[start : start + _BLOCK_SOURCES]
        position = to_test_mass_frame(test_mass, points[index])
        inside = test_mass.body.first_inside(position)
        if inside is not None:
            node = _node_name(int(index[inside]), node_ids)
            raise PhysicsError(
                f"{node} ({masses[index[inside]]:.6g} kg) {test_mass.body.inside_fact(position[inside])}",
                where=f"test mass {test_mass.name!r}",
                hint="leave the test mass itself out of the source model, or correct its position and size",
            )
        yield index, position, masses[index]


def _node_name(index: int, node_ids: Sequence[int] | IntArray | None) -> str:
    return f"source {index}" if node_ids is None else f"node {node_ids[index]}"
