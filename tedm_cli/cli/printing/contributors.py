"""What -v adds to the verdicts of cases: the sensitivity of every verdict, contributors, and what would mend it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from tedm_cli.cli.printing.table import table
from tedm_cli.results.wording import parts_noun, the_bench

if TYPE_CHECKING:
    from tedm_cli.noise.case_run import CaseResult
    from tedm_cli.noise.disturbances import DisturbanceContributions
    from tedm_cli.noise.requirements import Verdict
    from tedm_cli.results.thermal.comparison import Comparison


def sensitivity_table(results: Sequence[CaseResult]) -> list[str]:
    """One line for each verdict of each case: the ratio for other filters, correlations and safety factors."""
    orders = next((r.filter_sensitivity.order for r in results if r.filter_sensitivity is not None), np.empty(0))
    head = (
        *("case", "output", "requirement", "ratio"),
        *(f"order {n:g}" for n in orders),
        *("minimum", "blocks min", "blocks max", "R >= 0", "maximum", "factor 1", "allowed"),
    )
    rows = []
    for r in results:
        for v, verdict in enumerate(r.verdicts):
            by_filter = r.filter_sensitivity
            filters = (
                [""] * len(orders)
                if by_filter is None
                else [f"{q.min():.3g}..{q.max():.3g}" for q in by_filter.ratio[v]]
            )
            numbers = (*r.bound_ratio[v], verdict.ratio / r.safety_factor, r.safety_factor * verdict.margin)
            rows.append((r.case.id, verdict.output, verdict.requirement, f"{verdict.ratio:.3g}", *filters,
                         *(f"{n:.3g}" for n in numbers)))  # fmt: skip
    if not rows:
        return []
    corners = next((r.filter_sensitivity.corner_hz for r in results if r.filter_sensitivity is not None), None)
    note = "minimum to maximum: ratio at the bounds over correlations (blocks: only that between the blocks unknown);"
    lines = ["", "sensitivity of the verdicts", *table(head, rows, right=tuple(range(3, len(head)))), note]
    if corners is not None:
        lines.append(f"order: over corners of {', '.join(f'{1e3 * c:g}' for c in corners)} mHz;")
    return [*lines, "factor 1: ratio without safety factor; allowed: safety factor at which the ratio is 1"]


def contributor_lines(r: CaseResult, most: int | None) -> list[str]:
    """For each verdict: areas, groups, shields, spectra and paths it comes from, and what would bring it down."""
    lines = []
    for v, verdict in enumerate(r.verdicts):
        o = r.outputs.labels.index(verdict.output)
        c = r.contributions
        at = f"{1e3 * c.frequency_hz[o]:.3g} mHz"
        lines += [
            "",
            f"case {r.case.id}, {verdict.output}, {verdict.requirement}: parts of the power at {at} (in band)",
        ]
        order = np.argsort(-np.abs(c.share[o]), kind="stable")[:most]
        areas = [
            f"{r.areas.name[i]} {c.amplitude[o, i]:+.2e} {_percent(c.share[o, i], c.band_share[o, i])}" for i in order
        ]
        what = "thermal nodes and areas" if r.case.thermal else "areas"
        lines.append(f"  {what} ({r.outputs.units[o]}/sqrt(Hz)): {', '.join(areas)}")
        level = r.temperature_asd[:, int(np.abs(r.frequency_hz - c.frequency_hz[o]).argmin())]
        sets = zip(r.temperature_set.tolist(), r.areas.unit, strict=True)
        spectra = np.array([f"no. {i} of {level[i]:.2g} {unit}/sqrt(Hz)" for i, unit in sets])
        by = [("groups", r.areas.group_by_unit), ("shield", r.areas.shield), ("temperature spectra", spectra)]
        for what, labels in by[: 2 if r.case.thermal else 3]:  # every thermal node has a spectrum of its own
            names, share, band = c.by(labels)
            parts = [(str(n), share[o, i], band[o, i]) for i, n in enumerate(names)]
            lines.append(f"  {what}: {_parts(parts, most)}")
        if r.disturbances is not None:
            lines += _disturbance_lines(r.disturbances, o, v, most)
        if verdict.output in c.path_share:
            shares = c.path_share[verdict.output].tolist(), c.path_band_share[verdict.output].tolist()
            listed = _parts(list(zip(c.path_names, *shares, strict=True)), most)
            lines.append(f"  {parts_noun(c.path_names)}: {listed}")
        made_of = r.outputs.parts_of_read_outs.get(verdict.output)
        if made_of is not None and made_of.distortion is not None:
            without = r.distortion_ratio[v]
            known = "not known with gradients within areas" if np.isnan(without) else f"{without:.3g}"
            lines.append(f"  ratio if {the_bench(r.outputs.benches)} did not move as one: {known}")
        lines.append(f"  largest over all correlations: {_signs(r, o, most)}")
        lines += _improvement_lines(r, v, verdict, most)
    return lines


def _disturbance_lines(of: DisturbanceContributions, o: int, v: int, most: int | None) -> list[str]:
    """Parts of the power by disturbance, and the factor on the level of each that just meets the requirement."""
    shares = of.share[o].tolist(), of.band_share[o].tolist()
    factors = zip(of.names, of.level_factor[v].tolist(), strict=True)
    needed = [f"{name} {'cannot alone' if np.isnan(f) else f'x {f:.3g}'}" for name, f in factors if not np.isinf(f)]
    return [
        f"  disturbances: {_parts(list(zip(of.names, *shares, strict=True)), most)}",
        f"  level of a disturbance that just meets it: {', '.join(needed) or 'none is felt'}",
    ]


def comparison_lines(r: CaseResult, found: Comparison | None) -> list[str]:
    """Which case of areas is most like a case of the thermal network, and its temperatures beside those assumed."""
    if found is None or found.resemblance is None:
        return []
    of = found.resemblance
    each = ", ".join(f"{i} {far:.3g}" for i, far in found.by_case.items())
    levels = zip(of.groups, of.asd.tolist(), of.assumed_asd.tolist(), strict=True)
    return [
        f"correlation of case {r.case.id} at 1 mHz: case {of.cases[0]} resembles it best (root mean square of"
        f" |difference| over pairs of nodes: {each})",
        "temperatures at 1 mHz (K/sqrt(Hz), in brackets those that cases assume): "
        + ", ".join(f"{group} {computed:.2g} ({assumed:.2g})" for group, computed, assumed in levels),
    ]


def more_dict(r: CaseResult) -> dict[str, Any]:
    """The same for a program; null where a group cannot meet a requirement alone, or may have any noise."""
    from tedm_cli.noise.bounds import BOUNDS
    from tedm_cli.noise.improvement import COUNTS

    listed = []
    for v, (verdict, i) in enumerate(zip(r.verdicts, r.improvements, strict=True)):
        listed.append(
            {
                "output": verdict.output,
                "requirement": verdict.requirement,
                "bound_ratio": dict(zip(BOUNDS, r.bound_ratio[v].tolist(), strict=True)),
                "distortion_ratio": r.distortion_ratio[v] if np.isfinite(r.distortion_ratio[v]) else None,
                "filter_ratio": None if r.filter_sensitivity is None else r.filter_sensitivity.ratio[v].tolist(),
                "ratio_with_areas_silent": dict(zip(map(str, COUNTS), i.silenced.tolist(), strict=True)),
                "worst_areas": [str(r.areas.name[a]) for a in i.worst.tolist() if a >= 0],
                "ratio_with_blocks_matched": dict(zip(map(str, COUNTS), i.matched.tolist(), strict=True)),
                "matched_blocks": [r.areas.name[r.blocks[b]].tolist() for b in i.match.tolist() if b >= 0],
                **({} if r.disturbances is None else _disturbances(r.disturbances, r, v)),
                "group_factor": {
                    g: f if np.isfinite(f) else None for g, f in zip(r.groups, i.group_factor.tolist(), strict=True)
                },
            }
        )
    return {"sensitivity": listed}


def _disturbances(of: DisturbanceContributions, r: CaseResult, v: int) -> dict[str, Any]:
    o = r.outputs.labels.index(r.verdicts[v].output)
    level = [f if np.isfinite(f) else None for f in of.level_factor[v].tolist()]
    return {
        "disturbance_share": dict(zip(of.names, of.share[o].tolist(), strict=True)),
        "disturbance_level_factor": dict(zip(of.names, level, strict=True)),
    }


def _improvement_lines(r: CaseResult, v: int, verdict: Verdict, most: int | None) -> list[str]:
    from tedm_cli.noise.improvement import COUNTS, QUIETER
    from tedm_cli.noise.selection import listed

    i = r.improvements[v]
    areas, blocks = (_capped(COUNTS, int((chosen >= 0).sum())) for chosen in (i.worst, i.match))
    ratios = [f"{n}: {i.silenced[k]:.3g} ({i.quieter[k]:.3g})" for k, n in areas]
    factors = [
        f"{g} {'cannot alone' if np.isnan(f) else f'x {f:.3g}'}"
        for g, f in zip(r.groups, i.group_factor.tolist(), strict=True)
    ]
    worst = ", ".join(str(r.areas.name[a]) for a in i.worst[:most].tolist() if a >= 0) or "none"
    names = [listed(r.areas.name[r.blocks[b]].tolist()) for b in i.match[:most].tolist() if b >= 0]
    match = "; ".join(names) or "none"
    matched = [f"{n}: {i.matched[k]:.3g}" for k, n in blocks if n > 1] or ["none lowers it"]
    return [
        f"  ratio with the worst areas silent (at 1/{QUIETER:g}): {', '.join(ratios)}; worst: {worst}",
        f"  ratio with blocks that share one temperature fluctuation: {', '.join(matched)}; best together: {match}",
        f"  temperature amplitude that just meets it: {', '.join(factors)}; all together x {verdict.margin:.3g}",
    ]


def _capped(counts: Sequence[int], most: int) -> list[tuple[int, int]]:
    """Places of the counts, and the counts, up to the first that is no less than there are to choose, cut to that."""
    shown = [(k, min(n, max(most, 1))) for k, n in enumerate(counts)]
    return [(k, n) for k, n in shown if k == 0 or shown[k - 1][1] < n]


def _parts(parts: list[tuple[str, float, float]], most: int | None) -> str:
    ranked = sorted(parts, key=lambda p: -abs(p[1]))
    shown = [f"{name} {_percent(share, band)}" for name, share, band in ranked[:most] if share or band]
    return ", ".join(shown) or "none"


def _percent(share: float, band: float) -> str:
    return f"{100 * share:.3g} % ({100 * band:.3g} %)"


def _signs(r: CaseResult, o: int, most: int | None) -> str:
    """Areas that the correlation of the maximum turns against the others, the largest contributions first."""
    amplitude = r.contributions.amplitude[o]
    order = np.argsort(-np.abs(amplitude), kind="stable")
    shown = [f"{'+' if amplitude[i] > 0 else '-'}{r.areas.name[i]}" for i in order[:most] if amplitude[i]]
    up, down = int((amplitude > 0).sum()), int((amplitude < 0).sum())
    more = f" and {up + down - len(shown)} more" if up + down > len(shown) else ""
    return f"{up} areas rise while {down} fall: {' '.join(shown)}{more}"
