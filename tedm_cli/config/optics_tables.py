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
from tedm_cli.quantities import EXPANSION, MATRIX_DIFFERENCE, RADIUS_OF_CURVATURE, REFRACTIVE_INDEX, WAVELENGTH

HalfSizes = Annotated[list[Length], Field(min_length=2, max_length=2)]
Name = Annotated[str, Field(pattern=OPTICAL_NAME)]
Sets = Annotated[dict[Name, Annotated[list[str], Field(min_length=1)]], Field(min_length=1)]
Grids = dict[Name, Id]
ReadOut = Annotated[list[Dof], Field(min_length=1)]

#: Keys that only a photodiode has, with the same names in `[tolerances]`.
RECOMBINATION_KEYS = ("beam_overlap_m", "beam_angle_rad", "path_mismatch_m")
_ANY = frozenset({"local_y", "aperture_m"})
_BENCH = _ANY | {"bench", "lever_ok"}

#: Keys beyond name, kind and ref_m: (needed, allowed) by kind. An imported S_BW leaves `grid` alone needed.
KEYS: dict[Kind, tuple[frozenset[str], frozenset[str]]] = {
    "test_mass": (frozenset({"normal", "front_offset_m"}), _ANY | {"axes", "read_out"}),
    "injector": (frozenset({"normal", "grid"}), _BENCH | {"opl_offset_m"}),
    "window": (frozenset({"normal", "grid", "thickness_m", "index"}), _BENCH | {"front_offset_m"}),
    "beamsplitter": (frozenset({"normal", "grid", "thickness_m", "index"}), _BENCH | {"front_offset_m"}),
    "mirror": (frozenset({"normal", "grid"}), _BENCH | {"front_offset_m", "thickness_m", "index"}),
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
    *RECOMBINATION_KEYS,
)


class ElementTable(Strict):
    """One `[[element]]`; which of the optional keys belong to it depends on its kind, and on S_BW being imported."""

    name: Name
    kind: Kind
    ref_m: Place
    normal: Direction | None = None
    front_offset_m: Offset | None = None
    thickness_m: LengthOrZero | None = None
    index: Annotated[float, Bounded(REFRACTIVE_INDEX)] | None = None
    local_y: Direction | None = None
    aperture_m: Length | HalfSizes | None = None
    opl_offset_m: OpticalPath | None = None
    grid: Id | None = None
    lever_ok: bool | None = None
    axes: OrthonormalAxes | None = None
    bench: Name | None = None
    read_out: ReadOut | None = None
    beam_overlap_m: LengthTolerance | None = None
    beam_angle_rad: AngleTolerance | None = None
    path_mismatch_m: LengthTolerance | None = None


class PathTable(Strict):
    """One `[[path]]`: the ordered steps of one beam to one photodiode."""

    photodiode: str
    beam: Beam
    steps: Annotated[list[str], Field(min_length=2)] | None = None
    wavefront_radius_m: Annotated[float, Bounded(RADIUS_OF_CURVATURE)] | None = None


class FrameTable(Strict):
    """The layout frame in the model's basic frame."""

    origin_m: Place
    axes: OrthonormalAxes


class TolerancesTable(Strict):
    """What the checks of the layout allow; see `optics.layout.Tolerances` and `Recombination`."""

    clearance_m: LengthOrZero = 0.0
    reference_point_m: LengthTolerance = 0.01
    lever_m: LengthTolerance = 0.02
    beam_overlap_m: LengthTolerance = 1e-4
    beam_angle_rad: AngleTolerance = 1e-4
    path_mismatch_m: LengthTolerance | None = None


class ExpansionTable(Strict):
    """One `[[test_mass_expansion]]`: a test mass that follows the temperature of a thermal area."""

    test_mass: str
    expansion_per_K: Annotated[float, Bounded(EXPANSION)]
    area: str


class ImportedTable(Strict):
    """Matrices made elsewhere, relative to the layout file, in place of those that follow from the layout."""

    S_BW: FileName | None = None
    P: FileName | None = None
    largest_difference: Annotated[float, Bounded(MATRIX_DIFFERENCE)] | None = None


class OpticsTables(Strict):
    """The whole layout file."""

    title: str
    wavelength_m: Annotated[float, Bounded(WAVELENGTH)]
    read_out: ReadOut
    frame: FrameTable
    tolerances: TolerancesTable = TolerancesTable()
    grids: Grids = Field(default_factory=dict)
    sets: Sets
    element: Annotated[list[ElementTable], Field(min_length=1)]
    path: Annotated[list[PathTable], Field(min_length=1)]
    test_mass_expansion: list[ExpansionTable] = Field(default_factory=list)
    imported: ImportedTable = ImportedTable()
