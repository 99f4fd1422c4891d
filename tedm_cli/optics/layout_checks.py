"""Checks of a layout that a person would make: beams inside apertures, together on photodiodes, nothing in their way.

All are judged on the nominal chief rays of all paths, and none stops at the first failure. An element without an
aperture is not judged for it and obstructs nothing.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.optics.layout import BeamPath, Kind, OpticalLayout
from tedm_cli.optics.obstruction import lateral_excess, obstructions
from tedm_cli.optics.trace import Hit, Poses, RayLostError, encounters, nominal_poses, output_of, step_label

Check = Literal[
    "trace",
    "aperture",
    "transmission",
    "overlap",
    "angle",
    "path_mismatch",
    "reference_point",
    "obstruction",
]


@dataclass(frozen=True)
class Finding:
    """One thing checked.

    Parameters
    ----------
    check : which of the checks.
    where : path, step and element, or the photodiode or element alone.
    element : the element that is judged.
    value, limit : what was found and what is allowed, in `unit`; None where the check has no number.
    passed : whether it is as it should be.
    fact, hint : what is wrong and by how much, and what to change; empty where it passed.
    severity : a warning does not make a layout invalid.
    """

    check: Check
    where: str
    element: str
    value: float | None
    limit: float | None
    unit: str
    passed: bool
    fact: str = ""
    hint: str = ""
    severity: Literal["error", "warning"] = "error"

    @property
    def margin(self) -> float | None:
        """What is left of the limit, in `unit`; negative where it is exceeded."""
        return None if self.value is None or self.limit is None else self.limit - self.value

    @property
    def line(self) -> str:
        """The failure in one line."""
        return f"{self.where}: {self.fact}; {self.hint}"


@dataclass(frozen=True)
class _TracedPath:
    path: BeamPath
    hits: tuple[Hit, ...]
    failure: RayLostError | None


def check_layout(layout: OpticalLayout) -> tuple[Finding, ...]:
    """Judge the nominal layout; lengths in m, angles in rad, positions in the layout frame.

    A path that cannot be traced is judged as far as its last sound step.
    """
    poses = nominal_poses(layout)
    kinds = {e.name: e.kind for e in layout.elements}
    traced = [_traced(layout, path, poses) for path in layout.paths]
    out: list[Finding] = []
    for path in traced:
        if path.failure is not None:
            out.append(_failed("trace", path.path, path.failure.step, path.failure.fact, path.failure.hint))
        out += _transmitting_mirrors(path.path, kinds)
        for hit in path.hits:
            out += _aperture(layout, path.path, hit)
    out += _recombination(layout, traced, poses)
    out += _reference_points(layout)
    for path in traced:
        out += _obstructions(layout, path, poses)
    return tuple(out)


def failures(findings: tuple[Finding, ...], severity: Literal["error", "warning"] = "error") -> tuple[Finding, ...]:
    """What failed with that severity."""
    return tuple(f for f in findings if not f.passed and f.severity == severity)


def _traced(layout: OpticalLayout, path: BeamPath, poses: Poses) -> _TracedPath:
    hits: list[Hit] = []
    try:
        for hit in encounters(layout, path, poses):
            hits.append(hit)
    except RayLostError as exc:
        return _TracedPath(path, tuple(hits), exc)
    return _TracedPath(path, tuple(hits), None)


def _failed(check: Check, path: BeamPath, number: int, fact: str, hint: str) -> Finding:
    """A failure at a step of a path that has no number."""
    return Finding(check, step_label(path, number), path.steps[number - 1].element, None, None, "", False, fact, hint)


def _transmitting_mirrors(path: BeamPath, kinds: Mapping[str, Kind]) -> Iterator[Finding]:
    for number, step in enumerate(path.steps, start=1):
        if step.op == "T" and kinds[step.element] == "mirror":
            fact = f"the beam goes through the mirror {step.element}"
            hint = f"make {step.element} a beamsplitter, or let the step reflect ({step.element}:R)"
            yield _failed("transmission", path, number, fact, hint)


def _aperture(layout: OpticalLayout, path: BeamPath, hit: Hit) -> Iterator[Finding]:
    element = layout.elements[hit.element]
    if element.aperture_m is None:
        return
    value, limit = lateral_excess(element, hit.point)
    limit -= layout.tolerances.clearance_m
    face = f", {hit.face} face" if element.thickness_m else ""
    passed = value <= limit
    kept = f" with {_mm(layout.tolerances.clearance_m)} of clearance" if layout.tolerances.clearance_m else ""
    yield Finding(
        "aperture",
        step_label(path, hit.step) + face,
        element.name,
        value,
        limit,
        "m",
        passed,
        ""
        if passed
        else f"the beam meets {element.name} {_mm(value - limit)} outside its aperture{kept}, at {_place(hit.point)}",
        "" if passed else f"move {element.name}, turn what steers the beam there, or correct aperture_m",
    )


def _recombination(layout: OpticalLayout, traced: list[_TracedPath], poses: Poses) -> Iterator[Finding]:
    """Spots, directions and optical paths of the two beams of each photodiode that both reach."""
    reached = {(t.path.photodiode, t.path.beam): t for t in traced if t.failure is None}
    for name in layout.photodiodes:
        if (name, "meas") not in reached or (name, "ref") not in reached:
            continue
        meas, ref = (reached[name, beam] for beam in ("meas", "ref"))
        allowed = layout.elements[layout.index(name)].recombination
        where = f"photodiode {name}"
        spots = float(np.linalg.norm(meas.hits[-1].point - ref.hits[-1].point))
        yield _judged("overlap", where, name, spots, allowed.overlap_m, "m", "the spots of its two beams lie", "apart")
        d1, d2 = meas.hits[-1].direction, ref.hits[-1].direction
        angle = float(np.arctan2(np.linalg.norm(np.cross(d1, d2)), d1 @ d2))
        yield _judged("angle", where, name, angle, allowed.angle_rad, "rad", "its two beams meet at an angle of", "")
        if allowed.path_mismatch_m is not None:
            lengths = [_opl(layout, t, poses) for t in (meas, ref)]
            yield _judged(
                "path_mismatch",
                where,
                name,
                abs(lengths[0] - lengths[1]),
                allowed.path_mismatch_m,
                "m",
                "its optical paths differ by",
                f"(measurement {lengths[0]:.6g} m, reference {lengths[1]:.6g} m)",
            )


def _judged(
    check: Check, where: str, element: str, value: float, limit: float, unit: str, before: str, after: str
) -> Finding:
    """A quantity of a photodiode against its tolerance."""
    if value <= limit:
        return Finding(check, where, element, value, limit, unit, True)
    shown, allowed = (_mm(value), _mm(limit)) if unit == "m" else (_angle(value), _angle(limit))
    hint = {
        "overlap": "align the last elements of either path, or widen beam_overlap_m",
        "angle": "turn the recombining element or the last one of either path, or widen beam_angle_rad",
    }.get(check, "change the opl_offset_m of an injector or the folding of a path, or widen path_mismatch_m")
    fact = " ".join(part for part in (before, shown, after) if part)
    return Finding(check, where, element, value, limit, unit, False, f"{fact}; allowed {allowed}", hint)


def _opl(layout: OpticalLayout, traced: _TracedPath, poses: Poses) -> float:
    source = layout.elements[layout.index(traced.path.steps[0].element)]
    return float(output_of(traced.hits, poses, source.opl_offset_m)[2])


def _reference_points(layout: OpticalLayout) -> Iterator[Finding]:
    """Distance of the reference points from the elements; a test mass has its own at its centre, inside it."""
    limit = layout.tolerances.reference_point_m
    for e in layout.bench:
        value = max(0.0, e.front_offset_m - e.thickness_m, -e.front_offset_m)
        passed = value <= limit
        yield Finding(
            "reference_point",
            f"element {e.name}",
            e.name,
            value,
            limit,
            "m",
            passed,
            ""
            if passed
            else f"the reference point of {e.name} lies {_mm(value)} off its surface; allowed {_mm(limit)}",
            ""
            if passed
            else "give ref_m on the element with its front_offset_m (in metres?), or widen reference_point_m",
            "warning",
        )


def _obstructions(layout: OpticalLayout, traced: _TracedPath, poses: Poses) -> Iterator[Finding]:
    """Bodies that a beam meets between two of its steps."""
    path = traced.path
    number, point = 1, poses.ref[layout.index(path.steps[0].element)]
    for hit in traced.hits:
        if hit.step != number:
            ends = (path.steps[number - 1].element, path.steps[hit.step - 1].element)
            for met in obstructions(layout, point, hit.point, ends):
                yield Finding(
                    "obstruction",
                    f"{step_label(path, number)} to {path.steps[hit.step - 1].label}",
                    met.element,
                    met.depth_m,
                    0.0,
                    "m",
                    False,
                    f"the beam passes through {met.element}, {_mm(met.depth_m)} inside its edge, at"
                    f" {_place(met.point)}",
                    f"move {met.element} out of the way, or list it as a step of the path",
                    "warning",
                )
        number, point = hit.step, hit.point


def _mm(length: float) -> str:
    return f"{1e3 * length:.3g} mm"


def _angle(angle: float) -> str:
    return f"{angle:.3g} rad ({np.degrees(angle):.3g} deg)"


def _place(point: FloatArray) -> str:
    return "(" + ", ".join(f"{v:.4f}" for v in point) + ") m"
