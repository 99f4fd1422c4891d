"""Matrices as another program would write them."""

from __future__ import annotations

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.optics.imported import (
    Conventions,
    ImportedSensitivity,
    LabelledMatrix,
    MotionConventions,
    import_sensitivity,
)
from tedm_cli.optics.labels import Labels, input_labels, output_labels
from tedm_cli.optics.layout import OpticalLayout

ANGLES = Conventions({"meas": "meas", "ref": "ref"}, "angle")


def labelled(layout: OpticalLayout, S: FloatArray) -> LabelledMatrix:
    return LabelledMatrix(S, output_labels(layout), input_labels(layout))


def nodes_at(layout: OpticalLayout, offsets: float) -> FloatArray:
    """Grids off the reference points, at random, [n_bench, 3] m, basic frame."""
    places = np.array([e.ref_m for e in layout.bench])
    places = places + offsets * np.random.default_rng(3).normal(size=places.shape)
    return places @ layout.axes + np.array(layout.frame_origin_m)


def imported(
    layout: OpticalLayout,
    S: FloatArray,
    nodes: FloatArray,
    points: str = "layout",
    accuracy: float | None = None,
) -> ImportedSensitivity:
    """S, in SI and the layout frame, about `points`."""
    outputs = Conventions(ANGLES.beams, "angle", accuracy=accuracy)
    return import_sensitivity(layout, labelled(layout, S), outputs, MotionConventions("layout", points), nodes)


def with_units(labels: Labels, units: dict[str, str]) -> Labels:
    """The same names, units by what stands behind the last underscore."""
    return Labels(labels.names, tuple(units[name.rpartition("_")[2]] for name in labels.names))
