"""The tables of the optical layout file, each strict in itself."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from tedm_cli.config.base import (
    OPTICAL_NAME,
    AngleTolerance,
    Bounded,
    Direction,
    FileName,
    Id,
    Length,
    LengthOrZero,
    LengthTolerance,
    Offset,
    OpticalPath,
    OrthonormalAxes,
    Place,
    Strict,
)
from tedm_cli.optics.layout import Beam, Dof, Kind
from tedm_cli.quantities import (
    EXPANSION,
    INDEX_CHANGE,
    MATRIX_DIFFERENCE,
    PLATE_EXPANSION,
    RADIUS_OF_CURVATURE,
    REFRACTIVE_INDEX,
    WAVELENGTH,
)

HalfSizes = Annotated[list[Length], Field(min_length=2, max_length=2)]
Name = Annotated[str, Field(pattern=OPTICAL_NAME)]
Sets = Annotated[dict[Name, Annotated[list[str], Field(min_length=1)]], Field(min_length=1)]
Grids = dict[Name, Id]
ReadOut = Annotated[list[Dof], Field(min_length=1)]

#: Keys that only a photodiode has, with the same names in `[tolerances]`.
RECOMBINATION_KEYS = ("beam_overlap_m", "beam_angle_rad", "path_mismatch_m")
_ANY = frozenset({"local_y", "aperture_m"})
_BENCH = _ANY | {"bench", "lever_ok"}

#: Keys of the glass of a plate: how it changes per kelvin, and of which area.
CHANGE_KEYS = ("dn_dT_1_K", "expansion_1_K")
_GLASS = _BENCH | set(CHANGE_KEYS) | {"area", "front_offset_m"}

#: Keys beyond name, kind and ref_m: (needed, allowed) by kind. An imported S_BW leaves `grid` alone needed.
KEYS: dict[Kind, tuple[frozenset[str], frozenset[str]]] = {
    "test_mass": (frozenset({"normal", "front_offset_m"}), _ANY | {"axes", "read_out"}),
    "injector": (frozenset({"normal", "grid"}), _BENCH | {"opl_offset_m"}),
    "window": (frozenset({"normal", "grid", "thickness_m", "index"}), _GLASS),
    "beamsplitter": (frozenset({"normal", "grid", "thickness_m", "index"}), _GLASS),
    "mirror": (frozenset({"normal", "grid"}), _GLASS | {"thickness_m", "index"}),
    "photodiode": (frozenset({"normal", "grid", "local_y"}), _BENCH | set(RECOMBINATION_KEYS)),
}
OPTIONAL_KEYS = (
    "normal",
    "grid",
    "front_offset_m",
    "thickness_m",
    "index",
    "local_y",
    "aperture_m",
    "opl_offset_m",
    "lever_ok",
    "axes",
    "bench",
    "read_out",
    *CHANGE_KEYS,
    "area",
    *RECOMBINATION_KEYS,
)


class ElementTable(Strict):
    """One optical element. Which of the keys belong to it depends on its kind, and on S_BW being imported."""

    name: Name = Field(description="Name of the element.")
    kind: Kind = Field(description="What it is.")
    ref_m: Place = Field(description="Reference point, about which the element turns; of a test mass its centre.")
    normal: Direction | None = Field(
        default=None,
        description="Unit vector towards the reflecting side; of an injector the direction of the beam, of a "
        "photodiode towards the light.",
    )
    front_offset_m: Offset | None = Field(
        default=None,
        description="The front plane passes through `ref_m + front_offset_m * normal`. A test mass needs it; "
        "of others 0 where left out.",
    )
    thickness_m: LengthOrZero | None = Field(
        default=None,
        description="Distance of the back plane behind the front, which carries the coating. Windows and beam "
        "splitters need it.",
    )
    index: Annotated[float, Bounded(REFRACTIVE_INDEX)] | None = Field(
        default=None, description="Refractive index of the substrate. Windows and beam splitters need it."
    )
    dn_dT_1_K: Annotated[float, Bounded(INDEX_CHANGE)] | None = Field(
        default=None,
        description="Change of the refractive index against vacuum per kelvin at the wavelength, of a plate. 0 where "
        "left out.",
    )
    expansion_1_K: Annotated[float, Bounded(PLATE_EXPANSION)] | None = Field(
        default=None,
        description="Coefficient of linear expansion of a plate, by which it becomes thicker about its middle plane. 0 "
        "where left out.",
    )
    area: str | None = Field(
        default=None,
        description="The thermal area whose temperature a plate has. That of its grid where left out, if the grid is "
        "in one area alone.",
    )
    local_y: Direction | None = Field(
        default=None,
        description="Unit vector of the y axis; x is `local_y` × `normal`. Photodiodes and rectangular "
        "apertures need it.",
    )
    aperture_m: Length | HalfSizes | None = Field(
        default=None,
        description="Clear radius, or half sizes [a, b] along x and y, about `ref_m`. Without it the aperture "
        "is not checked.",
    )
    opl_offset_m: OpticalPath | None = Field(
        default=None, description="Optical path before an injector; 0 where left out."
    )
    grid: Id | None = Field(
        default=None,
        description="Grid of the finite-element model whose motion the element follows. Needed for all but "
        "test masses, here or in `[grids]`.",
    )
    lever_ok: bool | None = Field(
        default=None, description="Whether the distance of the element from its grid is meant, however long."
    )
    axes: OrthonormalAxes | None = Field(
        default=None,
        description="Unit vectors of a test mass as rows, layout frame. Those of the layout where left out.",
    )
    bench: Name | None = Field(
        default=None, description="Name of the bench that the element is on. Else elements that beams join are on one."
    )
    read_out: ReadOut | None = Field(
        default=None, description="What is measured of this test mass, in place of the layout's `read_out`."
    )
    beam_overlap_m: LengthTolerance | None = Field(
        default=None, description="Tolerance of this photodiode in place of that of `[tolerances]`."
    )
    beam_angle_rad: AngleTolerance | None = Field(default=None, description="The same of the angle.")
    path_mismatch_m: LengthTolerance | None = Field(default=None, description="The same of the optical paths.")


class PathTable(Strict):
    """One beam to one photodiode."""

    photodiode: str = Field(description="Name of the photodiode.")
    beam: Beam = Field(description="Which of its two beams: measurement or reference.")
    steps: Annotated[list[str], Field(min_length=2)] | None = Field(
        default=None,
        description="Injector, then `NAME:R` (reflected) or `NAME:T` (transmitted) of every element that is "
        "met, last the photodiode. An imported S_BW needs none.",
    )
    wavefront_radius_m: Annotated[float, Bounded(RADIUS_OF_CURVATURE)] | None = Field(
        default=None,
        description="Radius of curvature of the wave front at the photodiode, positive where it diverges. A "
        "plane wave where left out.",
    )


class FrameTable(Strict):
    """The layout frame in the model's basic frame."""

    origin_m: Place = Field(description="Origin of the layout frame.")
    axes: OrthonormalAxes = Field(description="Unit vectors of the layout frame as rows.")


class TolerancesTable(Strict):
    """What the checks of the layout allow."""

    clearance_m: LengthOrZero = Field(
        default=0.0,
        description="Distance that the axis of a beam keeps from edges of apertures and from bodies it shall "
        "not meet. Three beam radii are a good value.",
    )
    reference_point_m: LengthTolerance = Field(
        default=0.01,
        description="Distance of a reference point from its substrate or surface, above which there is a warning.",
    )
    lever_m: LengthTolerance = Field(
        default=0.02, description="Distance of an element from its grid, above which there is a warning."
    )
    beam_overlap_m: LengthTolerance = Field(
        default=1e-4, description="Largest distance of the two spots on a photodiode."
    )
    beam_angle_rad: AngleTolerance = Field(default=1e-4, description="Largest angle between its two beams.")
    path_mismatch_m: LengthTolerance | None = Field(
        default=None, description="Largest difference of their optical paths. Not judged where left out."
    )


class ExpansionTable(Strict):
    """A test mass that expands with the temperature of a thermal area."""

    test_mass: str = Field(description="Name of the test mass.")
    expansion_per_K: Annotated[float, Bounded(EXPANSION)] = Field(description="Its coefficient of linear expansion.")
    area: str = Field(description="The thermal area whose temperature it has.")


class ImportedTable(Strict):
    """Matrices made elsewhere. Names of files are relative to this one."""

    S_BW: FileName | None = Field(default=None, description="File of a matrix S_BW made elsewhere: CSV, NPZ or MAT.")
    P: FileName | None = Field(default=None, description="File of a matrix P made elsewhere.")
    largest_difference: Annotated[float, Bounded(MATRIX_DIFFERENCE)] | None = Field(
        default=None,
        description="Largest difference from the layout's own trace, as a part of the largest effect, above which the "
        "S_BW is refused. Not judged where left out.",
    )


class OpticsTables(Strict):
    """The optical layout. Vectors are in the layout frame unless another is named."""

    title: str = Field(description="Name of the bench.")
    wavelength_m: Annotated[float, Bounded(WAVELENGTH)] = Field(description="Wavelength in vacuum.")
    read_out: ReadOut = Field(
        description="What is measured of every test mass along and about its own axes; theta, eta, phi turn "
        "about x, y, z."
    )
    frame: FrameTable = Field(description="The layout frame in the basic frame of the model.")
    tolerances: TolerancesTable = Field(default=TolerancesTable(), description="What the checks of the layout allow.")
    grids: Grids = Field(
        default_factory=dict, description="Grid of each element by its name, in place of the elements' own `grid`."
    )
    sets: Sets = Field(
        description="Redundant sets of read-outs, by name: photodiodes that read all test masses. One is enough."
    )
    element: Annotated[list[ElementTable], Field(min_length=1)] = Field(
        description="The optical elements, in the order of the columns of S_BW."
    )
    path: Annotated[list[PathTable], Field(min_length=1)] = Field(
        description="The beams, one measurement and one reference for each photodiode, in the order of the "
        "rows of S_BW."
    )
    test_mass_expansion: list[ExpansionTable] = Field(
        default_factory=list, description="Test masses that expand with a thermal area."
    )
    imported: ImportedTable = Field(
        default=ImportedTable(), description="Matrices made elsewhere, in place of those that follow from the layout."
    )
