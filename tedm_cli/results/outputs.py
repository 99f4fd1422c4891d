"""All outputs of a model as rows per kelvin: self-gravity and read-outs, and what the read-outs are made of."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.contracts import OPTICS as OPTICS_KIND
from tedm_cli.contracts import SENSITIVITY as SENSITIVITY_KIND
from tedm_cli.errors import InputError
from tedm_cli.files.build_folder import DISTORTION, require_same_areas, require_same_input
from tedm_cli.files.store import open_checked
from tedm_cli.noise.areas import AreaTable
from tedm_cli.noise.contributions import ReadOutParts
from tedm_cli.noise.differences import terms, with_differences
from tedm_cli.noise.requirements import AppliedRequirement
from tedm_cli.optics.layout import N_MOTIONS
from tedm_cli.optics.shares import motion_terms
from tedm_cli.results.areas import read_area_table

_READ_OUT_KIND = {"m": "displacement", "rad": "angle"}


@dataclass(frozen=True)
class Outputs:
    """All outputs as rows per kelvin [n_out, k], with their labels and quantities, and the areas of the columns.

    `parts_of_read_outs`: by label of a read-out, what it is made of.
    """

    areas: AreaTable
    area_id: IntArray
    rows: FloatArray
    labels: list[str]
    kinds: list[str]
    parts_of_read_outs: dict[str, ReadOutParts]

    def with_differences(self, requirements: Sequence[AppliedRequirement]) -> Outputs:
        """With the differences of outputs that requirements judge."""
        rows, labels, kinds = with_differences(self.rows, self.labels, self.kinds, requirements)
        parts_of_read_outs = dict(self.parts_of_read_outs)
        for label in labels[len(self.labels) :]:
            first, second = terms(label) or ("", "")
            if first in parts_of_read_outs and second in parts_of_read_outs:
                parts_of_read_outs[label] = parts_of_read_outs[first] - parts_of_read_outs[second]
        return replace(self, rows=rows, labels=labels, kinds=kinds, parts_of_read_outs=parts_of_read_outs)


def read_outputs(sensitivity: Path, optics: Path) -> Outputs:
    """Gather the rows of both families; refuse files that stem from different distortion matrices."""
    with open_checked(sensitivity, SENSITIVITY_KIND) as s, open_checked(optics, OPTICS_KIND) as o:
        require_same_input(DISTORTION, s, o)
        require_same_areas(s, o)
        areas = read_area_table(s)
        labels = s.strings("/row/label")
        rows = [_finite(s.array("/S"), labels, sensitivity, "/S")]
        kinds = ["angular_acceleration" if u.startswith("rad") else "acceleration" for u in s.strings("/row/unit")]
        read_out, units = o.strings("/label/read_out"), o.strings("/label/read_out_unit")
        parts_of_read_outs: dict[str, ReadOutParts] = {}
        elements = [label.rpartition("_")[0] for label in o.strings("/label/element_dof")[::N_MOTIONS]]
        motion, rigid = o.array("/motion"), o.array("/rigid_motion")
        for name in o.strings("/set/name"):
            rows.append(_finite(o.array(f"/N/{name}"), read_out, optics, f"/N/{name}"))
            labels += [f"{name}_{label}" for label in read_out]
            kinds += [_READ_OUT_KIND[u] for u in units]
            gain = o.array(f"/gain/{name}")
            by_motion = motion_terms(gain, motion)
            by_element = by_motion.reshape(len(by_motion), len(elements), N_MOTIONS, -1).sum(axis=2)
            distortion = gain @ (motion - rigid)
            for i, label in enumerate(read_out):
                parts_of_read_outs[f"{name}_{label}"] = ReadOutParts(tuple(elements), by_element[i], distortion[i])
        return Outputs(areas, s.array("/area/id"), np.concatenate(rows), labels, kinds, parts_of_read_outs)


def _finite(rows: FloatArray, labels: Sequence[str], path: Path, dataset: str) -> FloatArray:
    """The rows [n, k] of a dataset; `InputError` names the first that is not finite."""
    for label, row in zip(labels, rows, strict=True):
        bad = row[~np.isfinite(row)]
        if bad.size:
            raise InputError(
                f"{dataset} is {bad[0]:g} in row {label}", where=str(path), hint="build the file again from its inputs"
            )
    return rows
