"""The drag-free loop and its budgets, as lines of text and for programs."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tedm_cli.cli.printing.table import table
from tedm_cli.cli.printing.titles import legend_lines

if TYPE_CHECKING:
    from tedm_cli.dynamics.judging import JudgedOutput
    from tedm_cli.stages.dynamics.build import DynamicsSummary
    from tedm_cli.stages.dynamics.simulate import Simulation

_LISTED = 0.01  # shares below this are not printed


def dynamics_lines(done: DynamicsSummary) -> list[str]:
    """Bodies, slowest pole and margins."""
    sc, found = done.loop.plant.spacecraft, done.stability
    centre = ", ".join(f"{x:g}" for x in sc.centre_of_mass_m)
    lines = [
        f"{done.path}: spacecraft of {sc.mass_kg:g} kg, centre of mass at ({centre}) m, basic frame;"
        f" {done.loop.names[0]} and {done.loop.names[1]} drag-free in x of {done.loop.names[0]}",
        f"electrostatic stiffness: {done.loop.config.stiffness.words()}",
        f"stable: {len(found.poles)} poles, slowest {found.largest_real_part:.3g} rad/s",
    ]
    rows = [
        (
            m.loop,
            f"{m.crossover_hz:.3g}",
            f"{m.phase_deg:.1f}",
            _decibel(m.gain_db),
            _decibel(m.reduction_db),
            f"{m.peak_sensitivity:.2f}",
        )
        for m in found.margins
    ]
    head = ("loop", "crossover Hz", "phase deg", "gain dB", "reduction dB", "peak S")
    return [*lines, *table(head, rows, right=(1, 2, 3, 4, 5)), "margins of each loop with the others closed"]


def _decibel(value: float) -> str:
    return f"{value:+.1f}" if np.isfinite(value) else "any"


def simulation_lines(path: Path, r: Simulation) -> list[str]:
    """Verdict table of a case in closed loop, and what dominates."""
    lines = [
        f"case {r.case.id} ({r.case.role}) in closed loop: {r.case.title} ({path})",
        f"temperature: {r.temperature.words()}; read-out set {r.rows.set_name};"
        f" ratio = safety factor {r.safety_factor:g} x noise / limit",
    ]
    if not r.judged:
        return [*lines, "no requirement applies"]
    rows = []
    for j in r.judged:
        v = j.verdict
        verdict = "pass" if v.passed else "FAIL"
        numbers = (f"{v.noise:.3g}", f"{v.limit:.3g}", f"{v.ratio:.3g}", f"{v.margin:.3g}", f"{v.binding_hz * 1e3:.3g}")
        rows.append((v.output, v.requirement, *numbers, verdict, _dominating(r, j)))
    head = ("output", "requirement", "noise", "limit", "ratio", "margin", "at mHz", "verdict", "made of")
    lines += table(head, rows, right=(2, 3, 4, 5, 6))
    lines += legend_lines((j.verdict.output, j.verdict.requirement) for j in r.judged)
    if r.realised is not None:
        ratio = r.realised.ratio.mean(axis=1)
        parts = ", ".join(f"{label} {value:.3f}" for label, value in zip(r.realised.labels, ratio, strict=True))
        plan = r.realised.plan
        how = f"{plan.samples:,} samples at {plan.rate_hz:g} Hz"
        lines.append(f"realised in time, {how}; mean of estimate over exact: {parts}")
    return lines + [line for j in r.judged if not j.verdict.passed for line in _help_lines(r, j)]


def _dominating(r: Simulation, j: JudgedOutput) -> str:
    order = np.argsort(j.share)[::-1]
    return ", ".join(f"{r.groups[g]} {100 * j.share[g]:.0f} %" for g in order[:3] if j.share[g] >= _LISTED)


def _help_lines(r: Simulation, j: JudgedOutput) -> list[str]:
    order = np.argsort(j.silenced)
    parts = []
    for g in order[:3]:
        if j.share[g] < _LISTED:
            continue
        factor = j.factor[g]
        alone = f"meets it at {factor:.2g} of its amplitude" if np.isfinite(factor) else "cannot meet it alone"
        parts.append(f"{r.groups[g]} {alone} (ratio without it {j.silenced[g]:.3g})")
    return [f"{j.verdict.output}, {j.verdict.requirement}: {'; '.join(parts)}"] if parts else []


def simulation_dict(path: Path, r: Simulation) -> dict[str, Any]:
    """What a program needs of a case in closed loop."""
    return {
        "case": r.case.id,
        "title": r.case.title,
        "role": r.case.role,
        "file": str(path),
        "safety_factor": r.safety_factor,
        "read_out_set": r.rows.set_name,
        "passed": all(j.verdict.passed for j in r.judged),
        "verdicts": [
            {
                "output": j.verdict.output,
                "requirement": j.verdict.requirement,
                "ratio": j.verdict.ratio,
                "binding_hz": j.verdict.binding_hz,
                "noise": j.verdict.noise,
                "limit": j.verdict.limit,
                "passed": j.verdict.passed,
                "share": dict(zip(r.groups, j.share.tolist(), strict=True)),
                "ratio_without": dict(zip(r.groups, j.silenced.tolist(), strict=True)),
                "thermal_incoherent_over_coherent": None if np.isnan(j.incoherent) else j.incoherent,
            }
            for j in r.judged
        ],
    }
