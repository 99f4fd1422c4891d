"""The file of one correlation case."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tedm_cli.arrays import IntArray
from tedm_cli.files.store import Writer
from tedm_cli.noise.bounds import BOUNDS
from tedm_cli.noise.case_run import CaseResult
from tedm_cli.noise.improvement import COUNTS
from tedm_cli.noise.requirements import Requirement, in_band


def write_case(writer: Writer, r: CaseResult, area_id: IntArray, requirements: Sequence[Requirement]) -> None:
    """Write the result of a case; `requirements` are all that were applied."""
    areas = r.areas
    writer.write("/area/id", area_id)
    for column in ("name", "group", "shield", "side"):
        writer.write(f"/area/{column}", [str(v) for v in getattr(areas, column)])
    block = np.full(len(areas), -1)
    for number, members in enumerate(r.blocks):
        block[members] = number
    writer.write("/case/id", r.case.id)
    writer.write("/case/title", r.case.title)
    writer.write("/case/role", r.case.role)
    writer.write("/case/reason", r.case.reason)
    writer.write("/case/safety_factor", r.safety_factor)
    writer.write("/case/block", block)
    matrix = r.source.correlation.matrix()
    writer.write("/correlation/real", np.ascontiguousarray(matrix.real))
    if np.iscomplexobj(matrix):
        writer.write("/correlation/imaginary", np.ascontiguousarray(matrix.imag))
    writer.write("/correlation/delay", r.source.correlation.delay_s)
    writer.write("/frequency", r.frequency_hz)
    writer.write("/temperature/spectrum", r.temperature_set)
    writer.write("/temperature/asd", r.temperature_asd)
    writer.write("/temperature/model", r.source.temperature.words())
    writer.write("/output/label", r.outputs.labels)
    writer.write("/output/unit", r.outputs.units)
    writer.write("/output/kind", r.outputs.kinds)
    c = r.contributions
    for i, (label, unit) in enumerate(zip(r.outputs.labels, r.outputs.units, strict=True)):
        power = f"({unit})^2/Hz"
        writer.write(f"/psd/{label}", r.psd[i], units=power)
        for bound in BOUNDS:
            writer.write(f"/bounds/{bound}/{label}", getattr(r.bounds, bound)[i], units=power)
        writer.write(f"/contribution/amplitude/{label}", c.amplitude[i], units=f"{unit}/sqrt(Hz)")
    for bound in BOUNDS:
        writer.write(f"/extremal/{bound}", c.extremal[bound])
    writer.write("/contribution/frequency", c.frequency_hz)
    writer.write("/contribution/share", c.share)
    writer.write("/contribution/band", c.band_hz)
    writer.write("/contribution/band_share", c.band_share)
    if c.path_share:
        writer.write("/path/name", c.path_names)
    for label in c.path_share:
        writer.write(f"/path/share/{label}", c.path_share[label])
        writer.write(f"/path/band_share/{label}", c.path_band_share[label])
    _write_verdicts(writer, r)
    _write_requirements(writer, r, requirements)


def _write_verdicts(writer: Writer, r: CaseResult) -> None:
    n = len(r.verdicts)
    writer.write("/verdict/requirement", [v.requirement for v in r.verdicts])
    writer.write("/verdict/output", [v.output for v in r.verdicts])
    writer.write("/verdict/ratio", [v.ratio for v in r.verdicts])
    writer.write("/verdict/binding_frequency", [v.binding_hz for v in r.verdicts])
    writer.write("/verdict/passed", [int(v.passed) for v in r.verdicts])
    writer.write("/verdict/allowed_safety_factor", [v.safety_factor * v.margin for v in r.verdicts])
    writer.write("/verdict/distortion_ratio", r.distortion_ratio)
    writer.write("/bound_ratio/bound", list(BOUNDS))
    writer.write("/bound_ratio/ratio", r.bound_ratio)
    if r.filter_sensitivity is not None:
        writer.write("/filter_sensitivity/order", r.filter_sensitivity.order)
        writer.write("/filter_sensitivity/corner", r.filter_sensitivity.corner_hz)
        writer.write("/filter_sensitivity/ratio", r.filter_sensitivity.ratio)
    writer.write("/improvement/count", np.array(COUNTS))
    for path, name in (("area", "worst"), ("matched_block", "match")):
        ranked = np.array([getattr(i, name) for i in r.improvements], dtype=int).reshape(n, COUNTS[-1])
        writer.write(f"/improvement/{path}", ranked)
    for name in ("silenced", "quieter", "matched"):
        ratios = np.array([getattr(i, name) for i in r.improvements]).reshape(n, len(COUNTS))
        writer.write(f"/improvement/{name}", ratios)
    writer.write("/stability/group", r.groups)
    factors = np.array([i.group_factor for i in r.improvements]).reshape(n, len(r.groups))
    writer.write("/stability/factor", factors)
    writer.write("/stability/all", [v.margin for v in r.verdicts])


def _write_requirements(writer: Writer, r: CaseResult, requirements: Sequence[Requirement]) -> None:
    writer.write("/requirement/name", [q.name for q in requirements])
    writer.write("/requirement/source", [q.source for q in requirements])
    writer.write("/requirement/unit", [f"{q.unit}/sqrt(Hz)" for q in requirements])
    writer.write("/requirement/applies_to", [q.applies_to for q in requirements])
    writer.write("/requirement/band", np.array([q.band_hz for q in requirements]).reshape(-1, 2))
    f = r.frequency_hz
    amplitude = np.full((len(requirements), len(f)), np.nan)
    for i, q in enumerate(requirements):
        inside = in_band(q, f)
        amplitude[i, inside] = q.amplitude(f[inside])
    writer.write("/requirement/amplitude", amplitude, units="see /requirement/unit")
