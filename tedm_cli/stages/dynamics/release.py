"""simulate --release: the loop without noise after coordinates are let go somewhere, at rest in all else.

As long as the slowest pole takes to make a ten-thousandth of what was there, or as `[time]` has samples.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tedm_cli import quantities as q
from tedm_cli.arrays import FloatArray
from tedm_cli.config.project import Project
from tedm_cli.contracts import RELEASE as KIND
from tedm_cli.dynamics.in_time import released, time_loop
from tedm_cli.dynamics.signals import COORDINATES, INPUTS, unit
from tedm_cli.dynamics.stability import stability
from tedm_cli.errors import InputError, PhysicsError, UsageError
from tedm_cli.files.build_folder import DYNAMICS_FILE, RELEASE_FILE, provenance
from tedm_cli.files.store import create
from tedm_cli.progress import Step, counter
from tedm_cli.stages.common import known_name, out_path
from tedm_cli.stages.dynamics.loop import project_loop
from tedm_cli.stages.dynamics.prepared import require_current_loop

_LABELS = (*COORDINATES, *(f"u_{name}" for name in INPUTS))
_LEFT = 1e-4  # of the slowest motion
_SETTLED = 0.01  # of the peak


@dataclass(frozen=True, eq=False)
class Release:
    """What became of coordinates that were let go: peaks [n] and times [n] (s) from which outputs stay small."""

    path: Path
    offset: Mapping[str, float]
    labels: tuple[str, ...]
    samples: int
    step_s: float
    peak: FloatArray
    settled_s: FloatArray


def offsets(texts: list[str]) -> dict[str, float]:
    """From `TM1_x=1e-6,TM2_theta=1e-5`; `UsageError` for what is no coordinate, no number or out of all bounds."""
    found: dict[str, float] = {}
    for part in (p for text in texts for p in text.split(",")):
        name, value = (piece.strip() for piece in part.partition("=")[::2])
        try:
            number = float(value)
        except ValueError:
            hint = "name coordinates with their offsets in m and rad: TM1_x=1e-6,SC_phi=1e-7"
            raise UsageError(f"--release {part!r} is no coordinate with a number", hint=hint) from None
        known_name("coordinate", name, COORDINATES)
        if fact := (q.OFFSET if unit(name) == "m" else q.ANGLE).fact(number):
            raise UsageError(f"--release {name}: {fact}")
        if name in found:
            raise UsageError(f"--release names {name} twice")
        found[name] = number
    return found


def release(project: Project, offset: Mapping[str, float], output: Path | None, step: Step) -> Release:
    """Let the loop go and write release.h5.

    Raises
    ------
    InputError : dynamics.h5 is missing or stale; samples that do not fit a sampled controller.
    """
    loop = project_loop(project)
    require_current_loop(project, loop)
    plan, step_s = loop.config.time, 1.0 / loop.config.time.rate_hz
    slowest = -stability(loop.plant, loop.controller).largest_real_part
    samples = min(plan.samples, int(np.ceil(-np.log(_LEFT) / slowest * plan.rate_hz)) + 1)
    in_time = time_loop(loop.plant, loop.controller, _LABELS)
    advance = counter(step, 2 * samples, "letting go")

    def blocks() -> Iterator[tuple[int, FloatArray]]:
        first = 0
        for block in released(in_time, dict(offset), step_s, samples):
            yield first, block
            first += block.shape[1]
            advance(block.shape[1])

    try:
        peak = np.max([np.abs(block).max(axis=1) for _, block in blocks()], axis=0)
    except PhysicsError as error:
        raise InputError(f"time.rate_hz: {error.fact}", where=loop.where, hint=error.hint) from error
    path, settled = out_path(project, RELEASE_FILE, output), np.zeros(len(_LABELS))
    with create(
        path, KIND, provenance([loop.file] if loop.file else [], [project.build_dir / DYNAMICS_FILE])
    ) as writer:
        time = writer.allocate(KIND.TIME, (samples,))
        series = [writer.allocate(KIND.SERIES.of(label), (samples,), units=unit(label)) for label in _LABELS]
        for first, block in blocks():
            part = slice(first, first + block.shape[1])
            time[part] = step_s * np.arange(part.start, part.stop)
            for target, values in zip(series, block, strict=True):
                target[part] = values
            large = np.abs(block) > _SETTLED * peak[:, None]
            last = np.where(large.any(axis=1), large.shape[1] - np.argmax(large[:, ::-1], axis=1), -first)
            settled = np.maximum(settled, step_s * (first + last))
        settled = np.where(settled > step_s * (samples - 1), np.inf, settled)
        writer.write(KIND.RELEASE_COORDINATE, list(offset))
        writer.write(KIND.RELEASE_OFFSET, list(offset.values()), units="m, rad")
        writer.write(KIND.OUTPUT_LABEL, list(_LABELS))
        writer.write(KIND.OUTPUT_UNIT, [unit(label) for label in _LABELS])
        writer.write(KIND.OUTPUT_PEAK, peak, units="see /output/unit")
        writer.write(KIND.OUTPUT_SETTLED, settled)
    return Release(path, offset, _LABELS, samples, step_s, peak, settled)
