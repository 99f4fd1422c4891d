"""Where S_BW and P come from: the layout, or files made elsewhere; either way they are judged before they are used."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from tedm_cli.arrays import FloatArray
from tedm_cli.config.base import read_toml
from tedm_cli.config.imported import law_of, sensitivity_of
from tedm_cli.config.optics.layout import OpticsConfig, beside
from tedm_cli.errors import ConfigError, InputError, PhysicsError
from tedm_cli.matrix_files.csv_file import read_csv
from tedm_cli.matrix_files.mat_file import read_mat
from tedm_cli.matrix_files.named import RawMatrix
from tedm_cli.matrix_files.npz_file import read_npz
from tedm_cli.optics.diagnosis import explain_defect, most_changed
from tedm_cli.optics.imported import ImportedSensitivity, import_law, import_sensitivity
from tedm_cli.optics.law import law_matrix
from tedm_cli.optics.layout import LAYOUT_AXES, OpticalLayout
from tedm_cli.optics.matrix_checks import (
    LARGEST_SKEW_RAD,
    BlockDifference,
    Judged,
    block_differences,
    judge_matrix,
)
from tedm_cli.optics.sensitivity import move_reference_points, optical_sensitivity

T = TypeVar("T")

_READERS: dict[str, Callable[[Path, str], RawMatrix]] = {".csv": read_csv, ".npz": read_npz, ".mat": read_mat}
_DECLARE = "correct the matrix, or declare its units, axes and reference points in a .toml file beside it"


@dataclass(frozen=True, eq=False)
class OpticalMatrices:
    """S_BW about the grids and P, with their verdicts, where they come from, and how S_BW differs from the trace."""

    S_BW: FloatArray
    P: FloatArray
    judged: tuple[Judged, ...]
    origins: tuple[str, str]
    differences: tuple[BlockDifference, ...]


def optical_matrices(config: OpticsConfig, position: FloatArray) -> OpticalMatrices:
    """The matrices of the chain, for grids at `position` [n_bench, 3] (m, basic frame).

    Raises
    ------
    ConfigError : something is missing in what is declared of an imported matrix; all of it is named.
    InputError : an imported file is not readable, or its labels or units are not those of the layout.
    PhysicsError : an invariance fails, or a set cannot tell its degrees of freedom apart; the slip that explains it is
        named, where one does.
    """
    layout = config.layout
    P, law_origin = law_matrix(layout), "layout"
    if config.P is not None:
        P, law_origin = _law(layout, config.P), f"imported from {config.P.name}"
    if config.S_BW is None:
        S_BW = move_reference_points(optical_sensitivity(layout), layout, position)
        judged = judge_matrix(layout, S_BW, P, position)
        if any(not j.passed for j in judged):
            raise PhysicsError(
                f"invariances of the optical sensitivity matrix fail: {_failed(judged)}",
                where=str(config.file.path),
                hint=_skew_faces(layout),
            )
        return OpticalMatrices(S_BW, P, judged, ("ray trace", law_origin), ())
    imported = _sensitivity(layout, config.S_BW, position)
    judged = _judge(layout, imported, P, position, config.S_BW)
    differences = _differences(config, imported, position)
    origin = f"imported from {config.S_BW.name} ({imported.digits})"
    return OpticalMatrices(imported.S_BW, P, judged, (origin, law_origin), differences)


def _judge(
    layout: OpticalLayout, imported: ImportedSensitivity, P: FloatArray, position: FloatArray, path: Path
) -> tuple[Judged, ...]:
    try:
        judged = judge_matrix(layout, imported.S_BW, P, position, imported.error)
    except PhysicsError as exc:
        cause = explain_defect(layout, imported, position)
        raise PhysicsError(
            f"{exc.fact}{'; ' if cause else ''}{cause}",
            where=f"{path}: {exc.where}",
            hint=_DECLARE if cause else exc.hint,
        ) from exc
    if all(j.passed for j in judged):
        return judged
    cause = explain_defect(layout, imported, position)
    hint = _DECLARE
    if not cause:
        cause = f"no single slip explains it; most changes {most_changed(layout, imported)}"
        hint = "if its entries are less accurate than their digits, declare accuracy = 1e-6 in a .toml file beside it"
    raise PhysicsError(f"invariances of S_BW fail: {_failed(judged)}; {cause}", where=str(path), hint=hint)


def _skew_faces(layout: OpticalLayout) -> str:
    """What to do about test masses whose face looks along none of their axes; empty where there is none."""
    for mass, off in zip(layout.test_masses, layout.skews_rad, strict=True):
        if off > LARGEST_SKEW_RAD:
            given = mass.axes != LAYOUT_AXES
            mend = "its `normal` has to be one of its `axes`" if given else "give the element the test mass's `axes`"
            return f"the face of {mass.name} looks {off:.2g} rad off its axes; {mend}"
    return ""


def _failed(judged: tuple[Judged, ...]) -> str:
    return ", ".join(f"{j.name} {j.value:.2g} (limit {j.limit:.1g})" for j in judged if not j.passed)


def _differences(
    config: OpticsConfig, imported: ImportedSensitivity, position: FloatArray
) -> tuple[BlockDifference, ...]:
    if not config.layout.has_geometry:
        return ()
    traced = move_reference_points(optical_sensitivity(config.layout), config.layout, position)
    found = block_differences(config.layout, imported.S_BW, traced)
    if config.largest_difference is not None and found[0].value > config.largest_difference:
        raise PhysicsError(
            f"S_BW differs from the layout's own trace by {found[0].value:.2g} of the largest effect at"
            f" {found[0].element} on {found[0].path}; allowed {config.largest_difference:.2g}",
            where=str(config.S_BW),
            hint="correct the layout or the matrix, or increase largest_difference",
        )
    return found


def _sensitivity(layout: OpticalLayout, path: Path, position: FloatArray) -> ImportedSensitivity:
    values, declared, where, hint = _read(path, "S_BW")
    matrix, outputs, motions = sensitivity_of(values, declared, where=where, hint=hint)
    return _placed(path, lambda: import_sensitivity(layout, matrix, outputs, motions, position))


def _law(layout: OpticalLayout, path: Path) -> FloatArray:
    values, declared, where, hint = _read(path, "P")
    matrix, outputs = law_of(values, declared, where=where, hint=hint)
    return _placed(path, lambda: import_law(layout, matrix, outputs))


def _placed(path: Path, make: Callable[[], T]) -> T:
    """What `make` returns; its refusals say which file they are about."""
    try:
        return make()
    except InputError as exc:
        raise InputError(exc.fact, where=str(path), hint=exc.hint) from exc


def _read(path: Path, name: str) -> tuple[FloatArray, dict[str, Any], str, str]:
    """The matrix, all that is declared of it in its file and beside it, where that is, and the hint for what lacks."""
    reader = _READERS.get(path.suffix.lower())
    if reader is None:
        raise InputError(
            "is neither CSV, NPZ nor MAT by its name", where=str(path), hint=f"known: {', '.join(_READERS)}"
        )
    side = beside(path)
    own: dict[str, Any] = {}
    if side.is_file():
        _, tables = read_toml(side)
        unknown = [(key, "unknown table; known are S_BW and P") for key in tables if key not in ("S_BW", "P")]
        if unknown or not isinstance(tables.get(name, {}), dict):
            raise ConfigError(unknown or [(name, "must be a table")], where=str(side))
        own = tables.get(name, {})
    variable = own.pop("variable", name)
    raw = reader(path, str(variable))
    twice = [(key, f"stands in {path.name} as well") for key in own if key in raw.declared]
    if twice:
        raise ConfigError(twice, where=str(side), hint="leave it out here")
    where = f"{side}" if side.is_file() else f"{path}"
    hint = f"declare it in {side.name} beside the matrix, in the table [{name}]"
    return raw.values, {**raw.declared, **own}, where, hint
