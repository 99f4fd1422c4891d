"""The optical layout as pure data: elements, ordered beam paths, read-out sets and the frame they are given in.

Vectors are in the layout frame. Element motions are six numbers, `ux uy uz` (m) and `rx ry rz` (rad), along and about
the layout axes, the rotation being about the element's reference point. Those of test masses are no exception; what is
measured of them, `x y z` and `theta eta phi`, is along and about each one's own axes, and `test_mass_motions` is where
the two meet.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np

from tedm_cli.arrays import FloatArray, IndexArray
from tedm_cli.errors import InputError

Vec3 = tuple[float, float, float]
Axes = tuple[Vec3, Vec3, Vec3]
Kind = Literal["test_mass", "injector", "window", "beamsplitter", "mirror", "photodiode"]
Beam = Literal["meas", "ref"]
Operation = Literal["emit", "R", "T", "detect"]
Dof = Literal["x", "y", "z", "theta", "eta", "phi"]

#: Place of a test-mass degree of freedom among the six motions; theta, eta, phi turn about x, y, z.
DOF_COLUMN: Mapping[Dof, int] = {"x": 0, "y": 1, "z": 2, "theta": 3, "eta": 4, "phi": 5}

LAYOUT_AXES: Axes = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))

N_OUTPUTS = 5  # x, y, opl, z1, z2 of one beam on one photodiode
N_MOTIONS = 6
N_LASER = 3  # OPD, WFT1, WFT2 of one photodiode


@dataclass(frozen=True)
class Recombination:
    """How well the two beams of a photodiode must meet.

    Parameters
    ----------
    overlap_m : distance of the two spots on the photodiode, m.
    angle_rad : angle between the two beams, rad.
    path_mismatch_m : difference of the optical paths, m; None where it does not matter.
    """

    overlap_m: float = 1e-4
    angle_rad: float = 1e-4
    path_mismatch_m: float | None = None


@dataclass(frozen=True)
class Tolerances:
    """What the checks of a layout allow.

    Parameters
    ----------
    clearance_m : distance that the axis of a beam keeps from the edge of an aperture and from other bodies, m; a few
        beam radii.
    reference_point_m : distance of an element's reference point from its substrate or surface, m.
    lever_m : distance of an element's reference point from the grid that carries it, m.
    """

    clearance_m: float = 0.0
    reference_point_m: float = 0.01
    lever_m: float = 0.02


@dataclass(frozen=True)
class Element:
    """One optical element.

    Parameters
    ----------
    name : unique name.
    kind : what the element is; test masses float freely, all others ride on the bench.
    ref_m : reference point of the element's rotation, m.
    normal : unit vector towards the reflecting side; of an injector the beam direction, of a photodiode towards the
        light.
    front_offset_m : the front plane passes through `ref_m + front_offset_m * normal`, m.
    thickness_m : distance of the back plane behind the front plane, m; zero for a surface without substrate,
        or for a plate so thin that its shift of the beam does not count.
    index : refractive index of the substrate.
    local_y : unit vector, y axis of the photodiode and of a rectangular aperture; None elsewhere.
    opl_offset_m : optical path already travelled before an injector, m.
    grid : finite-element grid that carries the motion; None for a test mass.
    aperture_m : clear radius, or half-sizes along `local_y x normal` and `local_y`, m, about the reference point, for
        all its planes; None where unknown.
    recombination : tolerances of a photodiode on its two beams.
    lever_ok : whether the lever from its grid is meant, however long.
    axes : of a test mass, its own x, y, z as rows, unit vectors of the layout frame.
    bench : the optical bench that it is on, where that is said; None: the one that its beams join it to.
    read_out : what is measured of a test mass; None: what is of all, `OpticalLayout.read_out`.
    dn_dT_per_K, expansion_per_K : of a plate, change of its index against vacuum, and linear expansion, 1/K.
    area : the thermal area whose temperature it has; None: that of its grid.
    """

    name: str
    kind: Kind
    ref_m: Vec3
    normal: Vec3
    front_offset_m: float = 0.0
    thickness_m: float = 0.0
    index: float = 1.0
    local_y: Vec3 | None = None
    opl_offset_m: float = 0.0
    grid: int | None = None
    aperture_m: float | tuple[float, ...] | None = None
    recombination: Recombination = Recombination()
    lever_ok: bool = False
    axes: Axes = LAYOUT_AXES
    bench: str | None = None
    read_out: tuple[Dof, ...] | None = None
    dn_dT_per_K: float = 0.0
    expansion_per_K: float = 0.0
    area: str | None = None

    @property
    def is_plate(self) -> bool:
        """Whether light passes through it, however thin it is: a plate may be met from behind."""
        return self.kind in ("window", "beamsplitter") or self.thickness_m > 0.0


@dataclass(frozen=True)
class Step:
    """One encounter of a beam with an element: emitted, reflected, transmitted or detected."""

    element: str
    op: Operation

    @property
    def label(self) -> str:
        """The step as the configuration writes it, e.g. ``BS3:T`` or ``PD1A``."""
        return f"{self.element}:{self.op}" if self.op in ("R", "T") else self.element


@dataclass(frozen=True)
class BeamPath:
    """The ordered steps of one beam to one photodiode, and its wave-front radius of curvature there (m; None: plane).

    A positive radius is a diverging beam: its centre of curvature lies upstream of the photodiode.
    """

    photodiode: str
    beam: Beam
    steps: tuple[Step, ...]
    wavefront_radius_m: float | None = None

    @property
    def label(self) -> str:
        return f"{self.photodiode} {self.beam}"


@dataclass(frozen=True)
class MassExpansion:
    """A test mass that expands by `expansion_per_K` (1/K) and follows the temperature of a thermal area."""

    test_mass: str
    expansion_per_K: float
    area: str


@dataclass(frozen=True)
class OpticalLayout:
    """Elements, beam paths and read-out sets, with the layout frame against the model's basic frame.

    Parameters
    ----------
    elements : in the order of the input columns, six columns each.
    paths : in the order of the output rows, five rows each.
    sets : name of a read-out set to its photodiodes.
    read_out : measured degrees of freedom of every test mass that names no others, along and about its own axes.
    frame_origin_m : origin of the layout frame in the basic frame, m.
    frame_axes : rows are the layout axes x, y, z in the basic frame.
    tolerances : what the checks of the layout allow.
    expansions : test masses that expand, at most one entry each.
    has_geometry : False where surfaces and steps need not be known because S_BW is imported; such a layout cannot be
        traced, its normals are zero and its paths may be without steps.
    """

    title: str
    wavelength_m: float
    elements: tuple[Element, ...]
    paths: tuple[BeamPath, ...]
    sets: Mapping[str, tuple[str, ...]]
    read_out: tuple[Dof, ...]
    frame_origin_m: Vec3 = (0.0, 0.0, 0.0)
    frame_axes: Axes = LAYOUT_AXES
    tolerances: Tolerances = Tolerances()
    expansions: tuple[MassExpansion, ...] = ()
    has_geometry: bool = True

    @cached_property
    def _element_index(self) -> dict[str, int]:
        return {e.name: i for i, e in enumerate(self.elements)}

    @cached_property
    def _path_index(self) -> dict[tuple[str, Beam], int]:
        return {(p.photodiode, p.beam): i for i, p in enumerate(self.paths)}

    def index(self, name: str) -> int:
        """Position of the element `name` in the layout order."""
        return self._element_index[name]

    def path_index(self, photodiode: str, beam: Beam) -> int:
        """Position of a beam path in the path order."""
        return self._path_index[photodiode, beam]

    def columns(self, name: str) -> slice:
        """The six input columns of the element `name`."""
        first = N_MOTIONS * self.index(name)
        return slice(first, first + N_MOTIONS)

    def rows(self, path: BeamPath) -> slice:
        """The five output rows of `path`."""
        first = N_OUTPUTS * self.path_index(path.photodiode, path.beam)
        return slice(first, first + N_OUTPUTS)

    @cached_property
    def test_masses(self) -> tuple[Element, ...]:
        """Test masses in layout order."""
        return tuple(e for e in self.elements if e.kind == "test_mass")

    @cached_property
    def bench(self) -> tuple[Element, ...]:
        """All elements but the test masses, in layout order."""
        return tuple(e for e in self.elements if e.kind != "test_mass")

    @cached_property
    def changing_plates(self) -> tuple[Element, ...]:
        """Plates whose glass changes with temperature, in layout order."""
        return tuple(e for e in self.elements if e.dn_dT_per_K or e.expansion_per_K)

    @cached_property
    def photodiodes(self) -> tuple[str, ...]:
        """Names of the photodiodes in layout order."""
        return tuple(e.name for e in self.elements if e.kind == "photodiode")

    def columns_of(self, elements: tuple[Element, ...]) -> IndexArray:
        """Input columns of several elements, six each, as indices [6 * len(elements)]."""
        first = N_MOTIONS * np.array([self.index(e.name) for e in elements], dtype=np.intp)
        return (first[:, None] + np.arange(N_MOTIONS)).reshape(-1)

    @cached_property
    def test_mass_axes(self) -> FloatArray:
        """Axes of the test masses as rows, [n_tm, 3, 3], layout frame: `v_own = axes @ v_layout`."""
        return np.array([e.axes for e in self.test_masses])

    @cached_property
    def test_mass_axes_basic(self) -> FloatArray:
        """The same in the model's basic frame: `v_own = axes @ v_basic`."""
        return np.asarray(self.test_mass_axes @ self.axes)

    @cached_property
    def skews_rad(self) -> FloatArray:
        """How far the face of each test mass looks off the nearest of its axes, [n_tm] rad."""
        across = [np.linalg.norm(np.cross(e.axes, e.normal), axis=1).min() for e in self.test_masses]
        return np.asarray(np.arcsin(np.clip(across, 0.0, 1.0)))

    @cached_property
    def has_own_axes(self) -> bool:
        """Whether the axes of any test mass are others than those of the layout."""
        return any(e.axes != LAYOUT_AXES for e in self.test_masses)

    @cached_property
    def test_mass_motions(self) -> FloatArray:
        """Motions of all elements, layout frame, when a test mass moves by one along or about each of its own axes.

        [6 * n_elements, 6 * n_tm], columns `x y z theta eta phi` (m, rad) of each test mass. They are orthonormal, so
        that the transpose takes motions to those of the test masses on their own axes.
        """
        out = np.zeros((N_MOTIONS * len(self.elements), N_MOTIONS * len(self.test_masses)))
        for i, mass in enumerate(self.test_masses):
            block = out[self.columns(mass.name), N_MOTIONS * i : N_MOTIONS * (i + 1)]
            block[:3, :3] = block[3:, 3:] = self.test_mass_axes[i].T
        return out

    @cached_property
    def read_out_motions(self) -> FloatArray:
        """The measured ones of `test_mass_motions`, test mass by test mass, [6 * n_elements, n_dof]."""
        places = [
            N_MOTIONS * i + DOF_COLUMN[dof] for i, mass in enumerate(self.test_masses) for dof in self.measured(mass)
        ]
        return np.asarray(self.test_mass_motions[:, places])

    def measured(self, mass: Element) -> tuple[Dof, ...]:
        """What is measured of a test mass."""
        return self.read_out if mass.read_out is None else mass.read_out

    def laser_rows(self, photodiodes: tuple[str, ...]) -> IndexArray:
        """Rows of OPD, WFT1, WFT2 of the given photodiodes [3 * len(photodiodes)]."""
        first = N_LASER * np.array([self.photodiodes.index(name) for name in photodiodes], dtype=np.intp)
        return (first[:, None] + np.arange(N_LASER)).reshape(-1)

    @cached_property
    def refs_m(self) -> FloatArray:
        """Reference points of all elements, [n_elements, 3] m."""
        return np.array([e.ref_m for e in self.elements])

    @cached_property
    def size_m(self) -> float:
        """Largest distance between two reference points, m."""
        return float(np.linalg.norm(self.refs_m[:, None] - self.refs_m[None], axis=2).max())

    @cached_property
    def axes(self) -> FloatArray:
        """Rotation from the basic into the layout frame, [3, 3]: `v_layout = axes @ v_basic`."""
        return np.array(self.frame_axes)

    def pivots_m(self, node_positions_m: FloatArray | None = None) -> FloatArray:
        """Points the motions of all elements refer to, [n_elements, 3] m, layout frame.

        Parameters
        ----------
        node_positions_m : finite-element nodes of the bench elements in layout order, [n_bench, 3] m, basic frame; None
            for the layout's own reference points. Test masses always keep theirs.

        Raises
        ------
        InputError : the array does not have one finite position per bench element.
        """
        pivots = self.refs_m.copy()
        if node_positions_m is None:
            return pivots
        nodes = np.asarray(node_positions_m, dtype=np.float64)
        if nodes.shape != (len(self.bench), 3) or not np.isfinite(nodes).all():
            raise InputError(
                f"node positions have shape {nodes.shape}; {len(self.bench)} finite ones in layout order are needed",
                where="optical elements",
                hint="give one grid per element that is not a test mass",
            )
        places = [self.index(e.name) for e in self.bench]
        pivots[places] = (nodes - np.array(self.frame_origin_m)) @ self.axes.T
        return pivots
