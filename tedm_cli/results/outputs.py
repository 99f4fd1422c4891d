"""All outputs of a model as rows per kelvin: self-gravity and read-outs, and what the read-outs are made of."""

from __future__ import annotations

import contextlib
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.config.halves import halves_of
from tedm_cli.config.model.file import load_model
from tedm_cli.config.project import Project
from tedm_cli.contracts import OPTICS, SENSITIVITY, AreaDatasets, FileKind
from tedm_cli.errors import InputError
from tedm_cli.files.build_folder import (
    DISTORTION_FILE,
    OPTICS_FILE,
    SENSITIVITY_FILE,
    require_configuration,
    require_same_areas,
    require_same_input,
    require_up_to_date,
)
from tedm_cli.files.store import Reader, open_checked
from tedm_cli.noise.contributions import ReadOutParts
from tedm_cli.noise.outputs import Outputs
from tedm_cli.results.areas import read_areas
from tedm_cli.results.cases.effects import effect_files, read_effects
from tedm_cli.results.gravity.self_gravity import read_self_gravity
from tedm_cli.results.optics import read_read_outs
from tedm_cli.results.sides import require_plane

_READ_OUT_KIND = {"m": "displacement", "rad": "angle"}
_UNIT = {"acceleration": "m/s^2", "angular_acceleration": "rad/s^2", **{k: u for u, k in _READ_OUT_KIND.items()}}


@dataclass(frozen=True, eq=False)
class ModelOutputs(Outputs):
    """The outputs of a build folder; `area_id` [k] are the numbers that the model gives its thermal areas.

    `matrices` are the files that they are in: of self-gravity and of the read-outs, as far as the project has them;
    `tables` those of effects of the user's own.
    """

    area_id: IntArray = field(kw_only=True)
    matrices: tuple[Path, ...] = field(kw_only=True)
    tables: tuple[Path, ...] = field(default=(), kw_only=True)

    @property
    def sources(self) -> tuple[Path, ...]:
        """All files that they are from."""
        return (*self.matrices, *self.tables)


@dataclass(frozen=True, eq=False)
class _Family:
    """The outputs of one file: rows [n, k] per kelvin, labels, kinds, and what read-outs are made of."""

    rows: FloatArray
    labels: list[str]
    kinds: list[str]
    parts: dict[str, ReadOutParts] = field(default_factory=dict)
    benches: int = 0


def read_outputs(project: Project) -> ModelOutputs:
    """Gather the rows of the families that the project has from its build folder.

    Raises
    ------
    InputError : files that stem from different distortion matrices, or were made with another configuration than the
        project has now, or with another symmetry plane; a table of effects that does not fit.
    ConfigError : the project has neither test masses nor optics.
    """
    model = load_model(project.model)[1]
    halves = halves_of(project, model)
    files: list[Reader] = []
    with contextlib.ExitStack() as stack:
        if halves.gravity:
            files.append(stack.enter_context(open_checked(project.build_dir / SENSITIVITY_FILE, SENSITIVITY)))
            require_configuration(files[-1], project.model)
        if project.optics is not None:
            files.append(stack.enter_context(open_checked(project.build_dir / OPTICS_FILE, OPTICS)))
            require_configuration(files[-1], project.optics)
        require_same_input(DISTORTION_FILE, *files)
        require_same_areas(files[0], *files[1:])
        for file in files:
            require_plane(file, project, model)
        outputs = _together(files)
        areas, labels = outputs.areas, outputs.labels
        effects = read_effects(project, model, labels, [_UNIT[kind] for kind in outputs.kinds], areas)
        rows, parts = effects.added_to(labels, outputs.rows, outputs.parts_of_read_outs)
        return replace(
            outputs,
            rows=rows,
            parts_of_read_outs=parts,
            effects=effects if effects.names else None,
            tables=tuple(effect_files(project, model)),
        )


def outputs_in(folder: Path, names: Sequence[str]) -> ModelOutputs:
    """The outputs in the files of these names in a build folder, whatever its project and its effects.

    Raises
    ------
    InputError : files that are missing or stale, or stem from different distortion matrices.
    """
    kinds: dict[str, FileKind] = {SENSITIVITY_FILE: SENSITIVITY, OPTICS_FILE: OPTICS}
    with contextlib.ExitStack() as stack:
        files = [stack.enter_context(open_checked(folder / name, kinds[name])) for name in names]
        for file in files:
            require_up_to_date(file)
        require_same_input(DISTORTION_FILE, *files)
        require_same_areas(files[0], *files[1:])
        return _together(files)


def _together(files: Sequence[Reader]) -> ModelOutputs:
    """The outputs of open files with the same areas."""
    families = [_gravity(file) if file.kind is SENSITIVITY else _read_outs(file) for file in files]
    return ModelOutputs(
        read_areas(files[0]),
        np.concatenate([f.rows for f in families]),
        tuple(label for f in families for label in f.labels),
        tuple(kind for f in families for kind in f.kinds),
        {label: parts for f in families for label, parts in f.parts.items()},
        benches=sum(f.benches for f in families),
        area_id=files[0].array(AreaDatasets.AREA_ID),
        matrices=tuple(file.path for file in files),
    )


def _gravity(file: Reader) -> _Family:
    gravity = read_self_gravity(file)
    kinds = ["angular_acceleration" if u.startswith("rad") else "acceleration" for u in gravity.unit]
    return _Family(_finite(gravity.S, gravity.label, file.path, SENSITIVITY.S), gravity.label, kinds)


def _read_outs(file: Reader) -> _Family:
    read_outs = read_read_outs(file)
    rows: list[FloatArray] = []
    parts: dict[str, ReadOutParts] = {}
    for name in read_outs.sets:
        rows.append(_finite(read_outs.N[name], read_outs.label, file.path, OPTICS.N.of(name)))
        by_part = read_outs.by_part(name)
        distortion = read_outs.gain[name] @ (read_outs.motion - read_outs.rigid_motion) + read_outs.N_plates(name)
        for i, label in enumerate(read_outs.label):
            parts[f"{name}_{label}"] = ReadOutParts(tuple(read_outs.part_names), by_part[i], distortion[i])
    kinds = [_READ_OUT_KIND[u] for u in read_outs.unit] * len(read_outs.sets)
    return _Family(np.concatenate(rows), read_outs.names, kinds, parts, len(read_outs.benches))


def _finite(rows: FloatArray, labels: Sequence[str], path: Path, dataset: str) -> FloatArray:
    """The rows [n, k] of a dataset; `InputError` names the first that is not finite."""
    for label, row in zip(labels, rows, strict=True):
        bad = row[~np.isfinite(row)]
        if bad.size:
            raise InputError(
                f"{dataset} is {bad[0]:g} in row {label}", where=str(path), hint="build the file again from its inputs"
            )
    return rows
