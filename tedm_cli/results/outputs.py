"""All outputs of a model as rows per kelvin: self-gravity and read-outs, and what the read-outs are made of."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.config.project import Project
from tedm_cli.contracts import OPTICS, SENSITIVITY
from tedm_cli.errors import InputError
from tedm_cli.files.build_folder import (
    DISTORTION_FILE,
    OPTICS_FILE,
    SENSITIVITY_FILE,
    require_configuration,
    require_same_areas,
    require_same_input,
)
from tedm_cli.files.store import open_checked
from tedm_cli.noise.contributions import ReadOutParts
from tedm_cli.noise.outputs import Outputs
from tedm_cli.results.areas import read_areas
from tedm_cli.results.optics import read_read_outs
from tedm_cli.results.self_gravity import read_self_gravity

_READ_OUT_KIND = {"m": "displacement", "rad": "angle"}


@dataclass(frozen=True, eq=False)
class ModelOutputs(Outputs):
    """The outputs of a build folder; `area_id` [k] are the numbers that the model gives its thermal areas."""

    area_id: IntArray = field(kw_only=True)


def read_outputs(project: Project) -> ModelOutputs:
    """Gather the rows of both families from the build folder of a project.

    Raises
    ------
    InputError : files that stem from different distortion matrices, or were made with another configuration than the
        project has now.
    """
    sensitivity, optics = project.build_dir / SENSITIVITY_FILE, project.build_dir / OPTICS_FILE
    with open_checked(sensitivity, SENSITIVITY) as s, open_checked(optics, OPTICS) as o:
        require_configuration(s, project.model)
        require_configuration(o, project.optics)
        require_same_input(DISTORTION_FILE, s, o)
        require_same_areas(s, o)
        areas = read_areas(s)
        gravity, read_outs = read_self_gravity(s), read_read_outs(o)
        labels = list(gravity.label)
        rows = [_finite(gravity.S, labels, sensitivity, SENSITIVITY.S)]
        kinds = ["angular_acceleration" if u.startswith("rad") else "acceleration" for u in gravity.unit]
        parts_of_read_outs: dict[str, ReadOutParts] = {}
        distorting = read_outs.motion - read_outs.rigid_motion
        for name in read_outs.sets:
            rows.append(_finite(read_outs.N[name], read_outs.label, optics, OPTICS.N.of(name)))
            kinds += [_READ_OUT_KIND[u] for u in read_outs.unit]
            by_element, distortion = read_outs.by_element(name), read_outs.gain[name] @ distorting
            for i, label in enumerate(read_outs.label):
                parts = ReadOutParts(tuple(read_outs.element), by_element[i], distortion[i])
                parts_of_read_outs[f"{name}_{label}"] = parts
        labels += read_outs.names
        return ModelOutputs(
            areas,
            np.concatenate(rows),
            tuple(labels),
            tuple(kinds),
            parts_of_read_outs,
            area_id=s.array(SENSITIVITY.AREA_ID),
        )


def _finite(rows: FloatArray, labels: Sequence[str], path: Path, dataset: str) -> FloatArray:
    """The rows [n, k] of a dataset; `InputError` names the first that is not finite."""
    for label, row in zip(labels, rows, strict=True):
        bad = row[~np.isfinite(row)]
        if bad.size:
            raise InputError(
                f"{dataset} is {bad[0]:g} in row {label}", where=str(path), hint="build the file again from its inputs"
            )
    return rows
