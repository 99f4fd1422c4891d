"""The drag-free loop and its budgets, as lines of text and for programs."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tedm_cli.cli.printing.series import series_dict, series_lines
from tedm_cli.cli.printing.table import table
from tedm_cli.cli.printing.titles import legend_lines
from tedm_cli.dynamics.signals import unit
from tedm_cli.results.cases.deciding import deciding
from tedm_cli.results.wording import and_text, ratio_text, rounded_down

if TYPE_CHECKING:
    from tedm_cli.dynamics.judging import JudgedOutput
    from tedm_cli.noise.correlation import CorrelationCase
    from tedm_cli.noise.requirements import Verdict
    from tedm_cli.stages.dynamics.build import DynamicsSummary
    from tedm_cli.stages.dynamics.release import Release
    from tedm_cli.stages.dynamics.series import SimulatedSeries
    from tedm_cli.stages.dynamics.simulate import Simulation

_LISTED = 0.01  # shares below this are not printed
_TOLD = 1e-3  # of the largest of a sort


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
            f"{m.crossover_hz:.3g}" if np.isfinite(m.crossover_hz) else "none",
            f"{m.phase_deg:.1f}" if np.isfinite(m.phase_deg) else "any",
            _decibel(m.gain_db),
            _decibel(m.reduction_db),
            f"{m.peak_sensitivity:.2f}",
        )
        for m in found.margins
    ]
    head = ("loop", "crossover Hz", "phase deg", "gain dB", "reduction dB", "peak S")
    return [*lines, *table(head, rows, right=(1, 2, 3, 4, 5)), "margins of each loop with the others closed"]


def dynamics_dict(done: DynamicsSummary) -> dict[str, Any]:
    """What a program needs; null where a margin is unlimited, or nothing is crossed."""
    sc, found = done.loop.plant.spacecraft, done.stability
    return {
        "file": done.path,
        "spacecraft": {"mass_kg": sc.mass_kg, "centre_of_mass_m": sc.centre_of_mass_m},
        "test_masses": done.loop.names,
        "electrostatic_stiffness": done.loop.config.stiffness.words(),
        "poles": [{"real_rad_s": p.real, "imaginary_rad_s": p.imag} for p in found.poles.tolist()],
        "slowest_pole_rad_s": found.largest_real_part,
        "loops": [
            {
                "loop": m.loop,
                "crossover_hz": m.crossover_hz,
                "phase_margin_deg": m.phase_deg,
                "gain_margin_db": m.gain_db,
                "gain_reduction_db": m.reduction_db,
                "peak_sensitivity": m.peak_sensitivity,
            }
            for m in found.margins
        ],
    }


def _decibel(value: float) -> str:
    return f"{value:+.1f}" if np.isfinite(value) else "any"


def simulation_lines(path: Path, r: Simulation) -> list[str]:
    """Verdict table of a case in closed loop, and what dominates."""
    lines = [
        f"case {r.case.id} ({r.case.role}) in closed loop: {r.case.title} ({path})",
        f"temperature: {r.source.words()}; read-out set {r.rows.set_name};"
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
    lines += [line for j in r.judged if j.disturbance_share is not None for line in _disturbance_lines(r, j)]
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


def _disturbance_lines(r: Simulation, j: JudgedOutput) -> list[str]:
    """Of a case of the thermal network: which disturbances the temperatures' part of an output comes from."""
    share = _disturbance_shares(r, j)
    whole = sum(share.values())
    if whole <= 0.0:
        return []
    largest = sorted(share.items(), key=lambda of: -abs(of[1]))[:3]
    told = ", ".join(f"{name} {100 * part / whole:.0f} %" for name, part in largest if abs(part) >= _LISTED * whole)
    return [f"{j.verdict.output}, {j.verdict.requirement}: temperatures ({100 * whole:.2g} % of the power) by {told}"]


def _disturbance_shares(r: Simulation, j: JudgedOutput) -> dict[str, float]:
    return dict(zip(r.disturbances, () if j.disturbance_share is None else j.disturbance_share.tolist(), strict=True))


def _disturbance_dict(r: Simulation, j: JudgedOutput) -> dict[str, Any]:
    """Shares of the disturbances, and the factors on their levels; null where one cannot alone, or is not felt."""
    if j.disturbance_factor is None:
        return {}
    share = _disturbance_shares(r, j)
    factor = [f if np.isfinite(f) else None for f in j.disturbance_factor.tolist()]
    return {"disturbance_share": share, "disturbance_level_factor": dict(zip(share, factor, strict=True))}


def _help_lines(r: Simulation, j: JudgedOutput) -> list[str]:
    """What would meet a violated requirement: groups that can alone, or those that are needed together."""
    alone = [g for g in np.argsort(-j.share, kind="stable") if np.isfinite(j.factor[g])]
    if alone:
        words = [
            f"{r.groups[g]} at {rounded_down(j.factor[g])} of its amplitude"
            f" (ratio without it {ratio_text(j.silenced[g])})"
            for g in alone
        ]
        help_words = f"met by {', or by '.join(words)}"
    else:
        needed = [g for g in np.argsort(-j.share, kind="stable") if j.together.groups[g]]
        without = ", ".join(f"without {r.groups[g]} alone {ratio_text(j.silenced[g])}" for g in needed)
        help_words = (
            f"no group alone; met by {and_text([r.groups[g] for g in needed])} together at"
            f" {rounded_down(j.together.factor)} of their amplitudes (ratio without them"
            f" {ratio_text(j.together.silenced)}; {without})"
        )
    return [f"{j.verdict.output}, {j.verdict.requirement}: {help_words}"]


def summary_lines(done: Sequence[Simulation]) -> list[str]:
    """Of several cases, every requirement on every output in the case that decides."""
    pairs: dict[tuple[str, str], list[tuple[CorrelationCase, Verdict]]] = {}
    made_of = {}
    for r in done:
        for j in r.judged:
            key = j.verdict.output, j.verdict.requirement
            pairs.setdefault(key, []).append((r.case, j.verdict))
            made_of[r.case.id, key] = _dominating(r, j)
    if len(done) < 2 or not pairs:
        return []
    rows = []
    for key, of_one in pairs.items():
        case, v = deciding(of_one)
        bad = sum(not verdict.passed for _, verdict in of_one)
        verdict = "pass" if v.passed else "FAIL"
        numbers = (f"{v.ratio:.3g}", f"{v.binding_hz * 1e3:.3g}")
        rows.append((*key, case.id, case.role, *numbers, verdict, f"{bad} of {len(of_one)}", made_of[case.id, key]))
    head = ("output", "requirement", "case", "role", "ratio", "at mHz", "verdict", "violated", "made of")
    return ["", "in the case that decides", *table(head, rows, right=(4, 5, 7))]


def _together_dict(r: Simulation, j: JudgedOutput) -> dict[str, Any]:
    groups = [name for name, needed in zip(r.groups, j.together.groups, strict=True) if needed]
    return {"groups": groups, "factor": j.together.factor, "ratio_without": j.together.silenced}


def simulation_dict(path: Path, r: Simulation) -> dict[str, Any]:
    """What a program needs of a case in closed loop."""
    return {
        "case": r.case.id,
        "title": r.case.title,
        "role": r.case.role,
        "file": str(path),
        "safety_factor": r.safety_factor,
        "read_out_set": r.rows.set_name,
        "passed": all(j.verdict.passed for j in r.judged) if r.judged else None,
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
                "factor_alone": {g: float(f) for g, f in zip(r.groups, j.factor, strict=True) if np.isfinite(f)},
                **_disturbance_dict(r, j),
                "together": None if j.verdict.passed else _together_dict(r, j),
                "thermal_incoherent_over_coherent": None if np.isnan(j.incoherent) else j.incoherent,
            }
            for j in r.judged
        ],
    }


def simulated_series_lines(r: SimulatedSeries) -> list[str]:
    """A temperature series in closed loop: as without, and of which parts."""
    lines = series_lines(r.total, {"rms of gravity": r.gravity_rms, "of read-out": r.read_out_rms})
    how = f"in closed loop, read-out set {r.read_out_set}; temperatures alone, without the noise of the loop"
    return [lines[0], how, *lines[1:]]


def simulated_series_dict(r: SimulatedSeries) -> dict[str, Any]:
    """What a program needs of a series in closed loop."""
    said = series_dict(r.total)
    for output, gravity, read_out in zip(said["outputs"], r.gravity_rms, r.read_out_rms, strict=True):
        output |= {"gravity_rms": float(gravity), "read_out_rms": float(read_out)}
    return said | {"read_out_set": r.read_out_set}


def release_lines(r: Release) -> list[str]:
    """How far everything goes, and when it is back; what stays a thousandth of the largest of its sort is left out."""
    sorts = [(unit(label), label.startswith("u_SC")) for label in r.labels]
    largest = {sort: max(p for p, of in zip(r.peak, sorts, strict=True) if of == sort) for sort in sorts}
    rows = [
        (label, f"{p:.3g}", unit(label), f"{s:.6g}" if np.isfinite(s) else "later")
        for label, p, sort, s in zip(r.labels, r.peak, sorts, r.settled_s, strict=True)
        if p > _TOLD * largest[sort]
    ]
    let_go = ", ".join(f"{name} at {value:g} {unit(name)}" for name, value in r.offset.items())
    return [
        f"let go: {let_go} ({r.path})",
        f"{r.samples:,} samples of {r.step_s:.6g} s over {(r.samples - 1) * r.step_s:.6g} s; what stays below"
        f" {_TOLD:g} of the largest coordinate, or command on spacecraft or test masses, is not listed",
        *table(("output", "peak", "unit", "within 1 % of it after s"), rows, right=(1, 3)),
    ]


def release_dict(r: Release) -> dict[str, Any]:
    """What a program needs of a release; `settled_s` is null where it is later than the end."""
    return {
        "file": str(r.path),
        "offset": dict(r.offset),
        "samples": r.samples,
        "step_s": r.step_s,
        "outputs": [
            {"output": label, "unit": unit(label), "peak": float(p), "settled_s": float(s) if np.isfinite(s) else None}
            for label, p, s in zip(r.labels, r.peak, r.settled_s, strict=True)
        ],
    }
