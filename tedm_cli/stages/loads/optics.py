"""What loads do to the optical elements, to the beams, and to the margins of the layout."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.contracts import LOADS, OPTICS
from tedm_cli.fem.structure import Structure
from tedm_cli.files.store import Reader, Writer
from tedm_cli.optics.chain import element_motion
from tedm_cli.optics.common_mode import common_mode
from tedm_cli.optics.exaggerated import motion_of_elements
from tedm_cli.optics.layout import OpticalLayout
from tedm_cli.optics.layout_checks import Finding, check_layout
from tedm_cli.optics.moved import findings_after


@dataclass(frozen=True, eq=False)
class Bench:
    """The layout of optics.h5 on a structure: rows [n] of the grids of the elements on benches, and their places."""

    file: Reader
    layout: OpticalLayout
    node: IntArray
    position_m: FloatArray

    @classmethod
    def on(cls, read_out: tuple[Reader, OpticalLayout], structure: Structure) -> Bench:
        """Of a structure that has all of its grids."""
        file, layout = read_out
        node = np.searchsorted(structure.grid_id, np.array([e.grid for e in layout.bench], dtype=np.int64))
        return cls(file, layout, node, structure.position[node])


def write_optics(writer: Writer, bench: Bench, optical: FloatArray, releases: Sequence[bool]) -> FloatArray:
    """Write motions of elements, beams and margins; the read-outs [r, k] of all sets by benches that move as one.

    Parameters
    ----------
    optical : [k, n, 6], motions of the grids of a bench, m and rad, basic frame.
    releases : [k], loads of a size, after which the layout is judged.
    """
    file, layout, at = bench.file, bench.layout, bench.position_m
    moved = element_motion(layout, optical)
    rigid = common_mode(layout, moved, at).motion
    writer.write(LOADS.LABEL_ELEMENT_DOF, file.strings(OPTICS.LABEL_ELEMENT_DOF))
    writer.write(LOADS.MOTION, moved, units="m or rad, per /load/unit")
    apart = (moved - rigid).reshape(len(layout.elements), 2, 3, len(optical))[:, 0]
    writer.write(LOADS.BENCH_DISTORTION, np.linalg.norm(apart, axis=1).max(axis=0), units="m per /load/unit")
    writer.write(LOADS.LABEL_RAY_OUTPUT, file.strings(OPTICS.LABEL_RAY_OUTPUT))
    writer.write(LOADS.LABEL_RAY_OUTPUT_UNIT, file.strings(OPTICS.LABEL_RAY_OUTPUT_UNIT))
    writer.write(LOADS.BEAM_SHIFT, file.array(OPTICS.S_BW) @ moved, units="see /label/ray_output_unit, per /load/unit")
    if layout.has_geometry:
        judged = [f for f in check_layout(layout) if _counts(f)]
        after = np.full((len(judged), len(optical)), np.nan)
        for k in np.flatnonzero(releases):
            after[:, k] = findings_after(layout, motion_of_elements(layout, optical[k], at), tuple(judged))
        writer.write(LOADS.MARGIN_CHECK, [f.check for f in judged])
        writer.write(LOADS.MARGIN_WHERE, [f.where for f in judged])
        writer.write(LOADS.MARGIN_ELEMENT, [f.element for f in judged])
        writer.write(LOADS.MARGIN_UNIT, [f.unit for f in judged])
        writer.write(LOADS.MARGIN_LIMIT, [f.limit for f in judged])
        writer.write(LOADS.MARGIN_BEFORE, [f.value for f in judged])
        writer.write(LOADS.MARGIN_AFTER, after)
    gains = [file.array(OPTICS.GAIN.of(name)) for name in file.strings(OPTICS.SET_NAME)]
    return np.concatenate([gain @ rigid for gain in gains])


def _counts(finding: Finding) -> bool:
    """Whether motions change it, and it has a margin."""
    return finding.margin is not None and finding.check not in ("reference_point", "obstruction")
