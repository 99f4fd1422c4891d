"""Field of a model's mass on a test mass, and the operator of its nodal displacements, from one set of sources."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.gravity.constants import G_CODATA_2018
from tedm_cli.gravity.field import FieldSum, SelfGravity
from tedm_cli.gravity.kernel import BodyField
from tedm_cli.gravity.masses import MassDistribution
from tedm_cli.gravity.quadrature import QuadraturePoints, quadrature_points
from tedm_cli.gravity.testmass import TestMass

COLUMNS = 24


@dataclass(frozen=True, eq=False, kw_only=True)
class StructureGravity:
    """Self-gravity of a model on one test mass.

    field : at rest and stiffness, in the frame of the test mass.
    operator : [2, 3, N, 3], acceleration and angular acceleration rows of G (frame of the test mass) per displacement
    of the grids (basic frame), 1/s² and 1/(m s²): ``S = -Σ G D``.
    rotation : [2, 3, L, 3], the same per rotation of the grids `lever_node` of the distribution.
    acceleration, angular_acceleration : [N, 3], see `nodal`; views of one array with `operator`, 192 bytes per grid.
    axes : [3, 3] of the test mass.
    sources : number of points summed.
    """

    field: SelfGravity
    operator: FloatArray
    rotation: FloatArray
    acceleration: FloatArray
    angular_acceleration: FloatArray
    axes: FloatArray
    sources: int

    def nodal(self, quantity: str) -> FloatArray:
        """Acceleration, angular_acceleration [N, 3] or gamma_lin [N, 3, 3] by the share of the mass of each grid.

        In the frame of the test mass; their sums over the grids are those of `field`.
        """
        if quantity == "gamma_lin":
            return np.asarray(self.operator[0].swapaxes(0, 1) @ self.axes.T)
        return {"acceleration": self.acceleration, "angular_acceleration": self.angular_acceleration}[quantity]


def structure_gravity(
    distribution: MassDistribution,
    test_mass: TestMass,
    *,
    tolerance: float,
    G: float = G_CODATA_2018,
    advance: Callable[[int], None] = lambda _: None,
) -> StructureGravity:
    """Sum the sources of a model on a test mass (Montemurro 2004, chapters 5, 6 and 8, corrected).

    The change of acceleration by displacements u(x) of the mass is ``-Σ_q m_q Γ_lin(x_q) u(x_q) / M``. Within an
    element ``u(x_q) = Σ_n N_n(x_q) (u_n + θ_n x w_n)``, with w_n the offset of the element from its node, so

        G[n] = Σ_q m_q N_n(x_q) Γ_lin(x_q)        G_rotation[n] = Σ_q m_q N_n(x_q) w_n x Γ_lin(x_q)   (row by row),

    and with Ω_lin in place of Γ_lin for the torque.

    Parameters
    ----------
    distribution : the model's mass.
    test_mass : the body acted upon.
    tolerance : relative error allowed in the quadrature over each element.
    G : gravitational constant [m³ kg⁻¹ s⁻²].
    advance : called with the number of elements done since the last call.

    Raises
    ------
    PhysicsError
        As `quadrature_points`.
    """
    from tedm_cli.gravity.gauss_points import add_rows

    n_nodes = len(distribution.position)
    nodal = np.zeros((n_nodes, COLUMNS))
    levers = np.zeros((len(distribution.lever_node), 18))
    total = FieldSum()
    count = 0
    for block in quadrature_points(distribution, test_mass, tolerance, advance):
        count += block.mass.size
        field, pulled = pull_back(block, test_mass)
        total.add(field, block.mass.ravel())
        add_rows(nodal, block.nodes.ravel(), pulled.reshape(-1, COLUMNS))
        if np.any(block.lever != 0.0):
            moment = np.cross(block.lever[:, :, None, :], pulled[..., :18].reshape(*block.nodes.shape, 6, 3))
            _add_levers(levers, distribution.lever_node, block, moment)
    turning = test_mass.per_inertia(G * np.eye(3))
    nodal[:, :9] *= G
    nodal[:, 9:18] = (turning @ nodal[:, 9:18].reshape(-1, 3, 3)).reshape(-1, 9)
    nodal[:, 18:] *= G
    nodal[:, 21:] = test_mass.per_inertia(nodal[:, 21:])
    rotation = levers.reshape(len(levers), 2, 3, 3)
    rotation = np.stack([G * rotation[:, 0], turning @ rotation[:, 1]])
    return StructureGravity(
        field=total.result(test_mass, G),
        operator=nodal[:, :18].reshape(n_nodes, 2, 3, 3).transpose(1, 2, 0, 3),
        rotation=rotation.swapaxes(1, 2),
        acceleration=nodal[:, 18:21],
        angular_acceleration=nodal[:, 21:],
        axes=test_mass.axes,
        sources=count,
    )


def pull_back(block: QuadraturePoints, test_mass: TestMass) -> tuple[BodyField, FloatArray]:
    """Field of the sources of a block (c q of them), and their coefficients at the nodes of each cell.

    The coefficients, [c, n, 24], are masses times, per unit G: Γ_lin (9) and Ω_lin (9) by rows, for displacements in
    the basic frame; force (3) and torque (3).
    """
    # The compiled loops are loaded here: importing the compiler takes longer than all the rest of the room.
    from tedm_cli.gravity.gauss_points import put_coefficients

    field = test_mass.body.field(block.position.reshape(-1, 3))
    coefficients = np.empty((*block.nodes.shape, COLUMNS))
    put_coefficients(
        *(field.gamma_lin, field.omega_lin, field.force, field.torque),
        *(test_mass.axes, block.mass, block.values, coefficients),
    )
    return field, coefficients


def _add_levers(target: FloatArray, lever_node: IntArray, block: QuadraturePoints, moment: FloatArray) -> None:
    on = np.any(block.lever != 0.0, axis=2)
    from tedm_cli.gravity.gauss_points import add_rows

    add_rows(target, np.searchsorted(lever_node, block.nodes[on]), moment[on].reshape(-1, 18))


def stack_rows(parts: Iterable[FloatArray]) -> FloatArray:
    """Operators [2, 3, n, 3] of t test masses as [6 t, n, 3] in the order of `sensitivity_row_labels`."""
    stacked = np.stack(list(parts), axis=1)
    return stacked.reshape(6 * stacked.shape[1], *stacked.shape[-2:])
