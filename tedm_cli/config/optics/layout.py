"""The optical layout file: read strictly, checked across its tables, and turned into the pure layout."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tedm_cli.config.base import named_by_project, read_toml, validate
from tedm_cli.config.optics.checks import Problems, cross_checks, imported_problems, lacks_geometry
from tedm_cli.config.optics.tables import ElementTable, OpticsTables, PathTable, TolerancesTable
from tedm_cli.errors import ConfigError, InputError
from tedm_cli.files.provenance import ConfigFile
from tedm_cli.optics.benches import benches
from tedm_cli.optics.layout import (
    LAYOUT_AXES,
    Axes,
    BeamPath,
    Element,
    MassExpansion,
    OpticalLayout,
    Recombination,
    Step,
    Tolerances,
    Vec3,
)


@dataclass(frozen=True)
class OpticsConfig:
    """The layout file: what was read, the layout, and the files of imported matrices, with the largest difference that
    an imported S_BW may have from the traced one (None: not judged)."""

    file: ConfigFile
    layout: OpticalLayout
    S_BW: Path | None
    P: Path | None
    largest_difference: float | None

    @property
    def matrices(self) -> tuple[Path, ...]:
        """The imported files that are there, with what is declared beside them."""
        files = [path for path in (self.S_BW, self.P) if path is not None]
        return tuple(dict.fromkeys(f for path in files for f in (path, beside(path)) if f == path or f.is_file()))


def beside(path: Path) -> Path:
    """The file that declares what the matrices in `path` mean: S_BW.csv.toml for S_BW.csv."""
    return path.with_name(path.name + ".toml")


def load_layout(path: Path, *, needs_grids: bool = True) -> tuple[ConfigFile, OpticalLayout]:
    """The layout alone; see `load_optics`."""
    config = load_optics(path, needs_grids=needs_grids)
    return config.file, config.layout


def load_optics(path: Path, *, needs_grids: bool = True) -> OpticsConfig:
    """Read and check the layout file at `path`.

    Without `needs_grids` elements need not name their grids: beams do not ask for them.

    Raises
    ------
    InputError : there is no such file.
    ConfigError : the file is not a valid layout; all its problems are listed with their dotted paths.
    """
    file, data = read_toml(path, hint=named_by_project("optics"))
    problems: Problems = []
    tables: OpticsTables | None = None
    try:
        tables = validate(OpticsTables, data, where=str(path))
    except ConfigError as exc:
        problems += exc.problems
    # A malformed table must not hide what is wrong in the others, so the checks run on whatever part is well formed.
    problems += cross_checks(data, needs_grids)
    if tables is not None:
        problems += imported_problems(tables)
    if problems or tables is None:
        raise ConfigError(problems, where=str(path))
    table, layout = tables.imported, _layout(tables)
    try:
        benches(layout)
    except InputError as exc:
        raise ConfigError([("element", exc.fact)], where=str(path)) from None
    return OpticsConfig(
        file,
        layout,
        None if table.S_BW is None else path.parent / table.S_BW,
        None if table.P is None else path.parent / table.P,
        table.largest_difference,
    )


def _layout(tables: OpticsTables) -> OpticalLayout:
    return OpticalLayout(
        title=tables.title,
        wavelength_m=tables.wavelength_m,
        elements=tuple(_element(e, tables) for e in tables.element),
        paths=tuple(_path(p) for p in tables.path),
        sets={name: tuple(photodiodes) for name, photodiodes in tables.sets.items()},
        read_out=tuple(tables.read_out),
        frame_origin_m=_vec3(tables.frame.origin_m),
        frame_axes=_axes(tables.frame.axes),
        has_geometry=not lacks_geometry(tables),
        tolerances=Tolerances(
            tables.tolerances.clearance_m, tables.tolerances.reference_point_m, tables.tolerances.lever_m
        ),
        expansions=tuple(MassExpansion(x.test_mass, x.expansion_per_K, x.area) for x in tables.test_mass_expansion),
    )


def _element(e: ElementTable, tables: OpticsTables) -> Element:
    return Element(
        name=e.name,
        kind=e.kind,
        ref_m=_vec3(e.ref_m),
        normal=(0.0, 0.0, 0.0) if e.normal is None else _vec3(_normalised(e.normal)),
        front_offset_m=e.front_offset_m or 0.0,
        thickness_m=e.thickness_m or 0.0,
        index=1.0 if e.index is None else e.index,
        local_y=None if e.local_y is None else _vec3(_across(e.local_y, e.normal)),
        opl_offset_m=e.opl_offset_m or 0.0,
        grid=tables.grids.get(e.name) if e.grid is None else e.grid,
        aperture_m=tuple(e.aperture_m) if isinstance(e.aperture_m, list) else e.aperture_m,
        recombination=_recombination(e, tables.tolerances),
        lever_ok=bool(e.lever_ok),
        bench=e.bench,
        read_out=None if e.read_out is None else tuple(e.read_out),
        dn_dT_per_K=e.dn_dT_1_K or 0.0,
        expansion_per_K=e.expansion_1_K or 0.0,
        area=e.area,
        axes=LAYOUT_AXES if e.axes is None else _axes(e.axes),
    )


def _recombination(e: ElementTable, common: TolerancesTable) -> Recombination:
    """The photodiode's own tolerances before those of the whole layout."""
    return Recombination(
        overlap_m=e.beam_overlap_m or common.beam_overlap_m,
        angle_rad=e.beam_angle_rad or common.beam_angle_rad,
        path_mismatch_m=e.path_mismatch_m or common.path_mismatch_m,
    )


def _path(p: PathTable) -> BeamPath:
    if p.steps is None:
        return BeamPath(p.photodiode, p.beam, (), p.wavefront_radius_m)
    steps = [Step(p.steps[0], "emit")]
    for text in p.steps[1:-1]:
        name, _, op = text.partition(":")
        steps.append(Step(name, "R" if op == "R" else "T"))
    steps.append(Step(p.steps[-1], "detect"))
    return BeamPath(p.photodiode, p.beam, tuple(steps), p.wavefront_radius_m)


def _vec3(v: Sequence[float]) -> Vec3:
    return (float(v[0]), float(v[1]), float(v[2]))


def _axes(rows: Sequence[Sequence[float]]) -> Axes:
    x, y, z = (_vec3(row) for row in rows)
    return x, y, z


def _across(local_y: Sequence[float], normal: Sequence[float] | None) -> list[float]:
    """The unit vector of local_y at right angles to the normal, from which printed digits may be off."""
    y = np.array(_normalised(local_y))
    n = np.zeros(3) if normal is None else np.array(_normalised(normal))
    return _normalised(y - (y @ n) * n)


def _normalised(v: Sequence[float]) -> list[float]:
    return list(np.array(v) / np.linalg.norm(v))
