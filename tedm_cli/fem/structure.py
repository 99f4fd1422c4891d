"""The structure a linear-static thermo-elastic solution needs, as plain arrays in SI units and one Cartesian frame."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from tedm_cli.arrays import BoolArray, FloatArray, IntArray


def no_ints(*shape: int) -> IntArray:
    """Integer array of the given (empty) shape, for blocks a structure does not have."""
    return np.zeros(shape, dtype=np.int64)


def no_floats(*shape: int) -> FloatArray:
    """Float array of the given (empty) shape, for blocks a structure does not have."""
    return np.zeros(shape)


@dataclass(frozen=True, eq=False, kw_only=True)
class SolidMaterials:
    """Linear elastic materials of solids in the basic frame; M materials.

    Attributes
    ----------
    stiffness : [M, 6, 6], Pa, in the order xx, yy, zz, xy, yz, zx with engineering shear strains.
    expansion : [M, 6], 1/K, thermal strain per kelvin in the same order.
    reference_temperature : [M], K, at which the material is free of thermal strain.
    """

    stiffness: FloatArray
    expansion: FloatArray
    reference_temperature: FloatArray


@dataclass(frozen=True, eq=False, kw_only=True)
class SolidBlock:
    """Solids of one kind; E elements of n nodes.

    Attributes
    ----------
    card : CHEXA, CPENTA or CTETRA.
    element_id : [E].
    connectivity : [E, n], rows of `Structure.position` in Nastran's order: 8 or 20, 6 or 15, 4 or 10 nodes.
    material : [E], rows of `materials`.
    materials : their table.
    bubble : whether linear hexahedra and pentahedra have incompatible modes (Nastran's bubble functions).
    """

    card: str
    element_id: IntArray
    connectivity: IntArray
    material: IntArray
    materials: SolidMaterials
    bubble: bool = False


@dataclass(frozen=True, eq=False, kw_only=True)
class BarBlock:
    """Straight prismatic bars between two grids; B bars.

    Attributes
    ----------
    element_id : [B].
    connectivity : [B, 2], rows of `Structure.position`, end A then end B.
    area : [B], m².
    inertia_1, inertia_2, inertia_12 : [B], m⁴: bending in plane 1 (bar axis and orientation vector), in plane 2,
        and their product of inertia.
    torsion_constant : [B], m⁴.
    shear_factor : [B, 2], share of the area that carries the shear force of plane 1 and of plane 2; infinite where
        shear does not deform. Without effect where `inertia_12` is not zero.
    youngs_modulus, shear_modulus : [B], Pa.
    expansion : [B], 1/K.
    reference_temperature : [B], K.
    orientation : [B, 3], vector that spans plane 1 together with the bar axis (any length).
    offset : [B, 2, 3], m, from the grids to the bar's ends: rigid arms that do not expand.
    released : bool [B, 12], freedoms that an end does not pass on to its grid: along and about the bar's axes x, y, z
        (three translations, three rotations), end A then end B.
    """

    element_id: IntArray = field(default_factory=lambda: no_ints(0))
    connectivity: IntArray = field(default_factory=lambda: no_ints(0, 2))
    area: FloatArray = field(default_factory=lambda: no_floats(0))
    inertia_1: FloatArray = field(default_factory=lambda: no_floats(0))
    inertia_2: FloatArray = field(default_factory=lambda: no_floats(0))
    inertia_12: FloatArray = field(default_factory=lambda: no_floats(0))
    torsion_constant: FloatArray = field(default_factory=lambda: no_floats(0))
    shear_factor: FloatArray = field(default_factory=lambda: no_floats(0, 2))
    youngs_modulus: FloatArray = field(default_factory=lambda: no_floats(0))
    shear_modulus: FloatArray = field(default_factory=lambda: no_floats(0))
    expansion: FloatArray = field(default_factory=lambda: no_floats(0))
    reference_temperature: FloatArray = field(default_factory=lambda: no_floats(0))
    orientation: FloatArray = field(default_factory=lambda: no_floats(0, 3))
    offset: FloatArray = field(default_factory=lambda: no_floats(0, 2, 3))
    released: BoolArray = field(default_factory=lambda: np.zeros((0, 12), dtype=np.bool_))


@dataclass(frozen=True, eq=False, kw_only=True)
class RodBlock:
    """Straight rods that resist stretch and twist alone; R rods, attributes as those of `BarBlock`."""

    element_id: IntArray = field(default_factory=lambda: no_ints(0))
    connectivity: IntArray = field(default_factory=lambda: no_ints(0, 2))
    area: FloatArray = field(default_factory=lambda: no_floats(0))
    torsion_constant: FloatArray = field(default_factory=lambda: no_floats(0))
    youngs_modulus: FloatArray = field(default_factory=lambda: no_floats(0))
    shear_modulus: FloatArray = field(default_factory=lambda: no_floats(0))
    expansion: FloatArray = field(default_factory=lambda: no_floats(0))
    reference_temperature: FloatArray = field(default_factory=lambda: no_floats(0))


@dataclass(frozen=True, eq=False, kw_only=True)
class ShellBlock:
    """Flat isotropic shells of one shape, triangles or quadrilaterals; E shells with n = 3 or 4 grids.

    Attributes
    ----------
    element_id : [E].
    connectivity : [E, n], rows of `Structure.position`, around the shell.
    membrane_stiffness : [E, 3, 3], N/m: forces per length over the strains xx, yy and the engineering shear strain.
    bending_stiffness : [E, 3, 3], N·m: moments per length over the curvatures, in the same order.
    shear_stiffness : [E], N/m, transverse force per length over the shear angle; infinite where shear does not deform.
    drilling_stiffness : [E], N/m, weight of (rotation about the normal - rotation of the mid-surface)².
    offset : [E], m, of the mid-surface from the grids along the normal.
    expansion, bending_expansion : [E], 1/K, of the membrane, and of the bending under a gradient through the thickness.
    reference_temperature : [E], K.
    law_rates : [E, 3], or None of shells as they are. Where given, matrices of the shells are what they change by, over
        the common factor of the membrane (with the tie of its drilling), of the bending and of the shear stiffness.
    """

    element_id: IntArray = field(default_factory=lambda: no_ints(0))
    connectivity: IntArray = field(default_factory=lambda: no_ints(0, 4))
    membrane_stiffness: FloatArray = field(default_factory=lambda: no_floats(0, 3, 3))
    bending_stiffness: FloatArray = field(default_factory=lambda: no_floats(0, 3, 3))
    shear_stiffness: FloatArray = field(default_factory=lambda: no_floats(0))
    drilling_stiffness: FloatArray = field(default_factory=lambda: no_floats(0))
    offset: FloatArray = field(default_factory=lambda: no_floats(0))
    expansion: FloatArray = field(default_factory=lambda: no_floats(0))
    bending_expansion: FloatArray = field(default_factory=lambda: no_floats(0))
    reference_temperature: FloatArray = field(default_factory=lambda: no_floats(0))
    law_rates: FloatArray | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class Rbe2:
    """Rigid body: the listed components of the dependent grids follow the six of the independent grid.

    `independent` and `dependents` [M] are rows of `Structure.position`; `components` are digits 1 to 6. `kind` is its
    card, for messages.
    """

    element_id: int
    independent: int
    dependents: IntArray
    components: str
    kind: str = "RBE2"


@dataclass(frozen=True, eq=False, kw_only=True)
class Rbe3:
    """Interpolation: the dependent grid follows the weighted mean motion of the independent grids.

    `dependent` and `independents` [M] are rows of `Structure.position`; `weights` [M]; `components` are the digits of
    the dependent grid, `independent_components` (one string per independent grid) those that enter the mean.
    """

    element_id: int
    dependent: int
    components: str
    independents: IntArray
    weights: FloatArray
    independent_components: tuple[str, ...]


@dataclass(frozen=True, eq=False, kw_only=True)
class Mpc:
    """One equation among displacements: the sum of `coefficients` [M] times the motions is zero.

    `grids` [M] are rows of `Structure.position`, `components` [M] 1 to 6; the first motion is the dependent one.
    """

    grids: IntArray
    components: IntArray
    coefficients: FloatArray


@dataclass(frozen=True, eq=False, kw_only=True)
class DirectStiffness:
    """A symmetric stiffness given as a matrix: of structures that are reduced to some of their grids.

    `dof` [m] are degrees of freedom 6 n + component - 1 along and about the axes of the grids' displacement frames;
    `matrix` [m, m] in N/m, N and N·m.
    """

    dof: IntArray = field(default_factory=lambda: no_ints(0))
    matrix: FloatArray = field(default_factory=lambda: no_floats(0, 0))


@dataclass(frozen=True, eq=False, kw_only=True)
class Structure:
    """Everything the stiffness, the thermal coupling and the constraints are made of.

    Attributes
    ----------
    grid_id : [N].
    position : [N, 3], m.
    displacement_frame : [N, 3, 3], unit vectors (columns, in the frame of the positions) along which each grid's
        components 1 to 3 of rigid elements and constraints count, and about which 4 to 6; None where all grids use the
        frame of the positions.
    solids : blocks of solid elements.
    bars, rods, quads, trias : blocks of the other elements.
    rbe2, rbe3, mpc : rigid and interpolation elements, and equations among displacements.
    spc_grid : [S], rows of `position`.
    spc_component : [S], 1 to 6; the constrained displacement is zero.
    initial_temperature : [N], K, or None. Where given it replaces the elements' reference temperatures.
    direct : stiffness besides that of the elements.
    """

    grid_id: IntArray
    position: FloatArray
    displacement_frame: FloatArray | None = None
    solids: tuple[SolidBlock, ...] = ()
    bars: BarBlock = field(default_factory=BarBlock)
    rods: RodBlock = field(default_factory=RodBlock)
    quads: ShellBlock = field(default_factory=ShellBlock)
    trias: ShellBlock = field(default_factory=lambda: ShellBlock(connectivity=no_ints(0, 3)))
    rbe2: tuple[Rbe2, ...] = ()
    rbe3: tuple[Rbe3, ...] = ()
    mpc: tuple[Mpc, ...] = ()
    spc_grid: IntArray = field(default_factory=lambda: no_ints(0))
    spc_component: IntArray = field(default_factory=lambda: no_ints(0))
    initial_temperature: FloatArray | None = None
    direct: DirectStiffness = field(default_factory=DirectStiffness)

    @property
    def n_grids(self) -> int:
        """Number of grids N; each has six degrees of freedom, 6 n + component - 1."""
        return len(self.grid_id)

    def in_displacement_frames(self, motion: FloatArray) -> FloatArray:
        """Motions [N, 6] given in the frame of the positions, in each grid's displacement frame."""
        if self.displacement_frame is None:
            return motion
        pairs = motion.reshape(-1, 2, 3) @ self.displacement_frame
        return np.asarray(pairs.reshape(motion.shape))


@dataclass(frozen=True, eq=False, kw_only=True)
class ElementTemperatures:
    """Temperatures of shells, bars and rods that do not take those of their grids; m elements.

    Attributes
    ----------
    element_id : [m], ascending.
    mean : [m, 2], K, over the section at ends A and B of a bar; of a shell over its volume, twice.
    gradient : [m, 2, 2], K/m, at ends A and B (second index) of a bar in its planes 1 and 2 (third index): along its
        y and z. Of a shell [:, :, 0] is along its normal, twice, and the rest is zero.
    """

    element_id: IntArray
    mean: FloatArray
    gradient: FloatArray


@dataclass(frozen=True, eq=False)
class OnFreedoms:
    """Values [n] on some degrees of freedom [n], 6 row + component - 1; of one that is named twice they add up."""

    dof: IntArray
    value: FloatArray


@dataclass(frozen=True, eq=False, kw_only=True)
class LoadCase:
    """One load of a structure of N grids: temperatures, forces, an acceleration and motions of its supports.

    Attributes
    ----------
    temperature : [N], K, on the grids, in their order; None where everything is free of thermal strain.
    elements : those with their own temperatures, whatever those of their grids; None where all follow the grids.
    force : N and N·m, in the frame of the positions.
    acceleration : [3], m/s², in the frame of the positions, which pulls on all mass as a field of gravity would.
    enforced : m and rad, of degrees of freedom that single-point constraints hold, along and about the axes of the
        grid's displacement frame; all others are held at zero.
    """

    id: int
    label: str
    temperature: FloatArray | None = None
    elements: ElementTemperatures | None = None
    force: OnFreedoms | None = None
    acceleration: FloatArray | None = None
    enforced: OnFreedoms | None = None
