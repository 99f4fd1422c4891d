"""The balance of the field at rest, as lines of text and for programs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from tedm_cli.cli.printing.table import table
from tedm_cli.results.gravity.field import place_text
from tedm_cli.results.wording import and_text, count, ratio_text

if TYPE_CHECKING:
    from tedm_cli.arrays import FloatArray
    from tedm_cli.gravity.requirements import DcVerdict
    from tedm_cli.results.gravity.balance import BalanceResults
    from tedm_cli.stages.balance.balance import BalanceSummary
    from tedm_cli.stages.balance.retrim import RetrimSummary

_LISTED = 0.01  # of a limit: quantities that stay below before and after are not printed


def balance_lines(done: BalanceSummary, most: int | None) -> list[str]:
    """Before and after, where the mass is, what blocks and what each limit costs."""
    r = done.results
    lines = [f"{done.path}: {summary_line(r)}"]
    lines += result_lines(r, most)
    for box, parts in done.left_out.items():
        if parts:
            lines.append(f"{box}: {count(parts, 'part')} left out, as they are in the way of something")
    if done.sought is not None:
        lines.append(
            f"places and sizes: {count(done.sought.numbers, 'number')} sought, by {done.sought.programmes:,} programmes"
        )
    if done.turning:
        lines.append(
            f"not in S_SG with blocks: {', '.join(done.turning[:8])}, whose grids do not define how they turn; the"
            " chain has them"
        )
    lines.append(
        f"{done.csv}: {count(len(r.block), 'block')}"
        + (f", and {done.kept} that the model has already" if done.kept else "")
    )
    key = "compensation_masses" if not done.replaced else "compensation_masses, without [[compensation_mass]] tables,"
    lines.append(f"to judge the balanced model: {key} = the CSV in the model's file, then `tedm run`")
    return lines


def summary_line(r: BalanceResults) -> str:
    """How many limits are met, and with what mass."""
    before = sum(v.passed for v in r.before)
    return (
        f"{r.met} of {len(r.after)} limits at rest are met with {r.total_kg:.4g} kg in {count(len(r.block), 'block')}"
        f" (without them {before})"
    )


def retrim_lines(done: RetrimSummary, most: int | None) -> list[str]:
    """Before and after, and how the shims of each block change."""
    r = done.results
    before = sum(v.passed for v in r.before)
    lines = [f"{done.path}: as measured, {before} of {len(r.before)} limits at rest are met; with other shims {r.met}"]
    lines += _limit_lines(r, most)
    lines += _change_lines(r)
    lines += _blocking_lines(r)
    lines.append(
        f"{done.csv}: {count(len(r.block), 'block')} as they are then, with {count(done.measured, 'part')} measured"
    )
    return lines


def _change_lines(r: BalanceResults) -> list[str]:
    assert r.mass_before_kg is not None
    assert r.shims_before is not None
    change = r.mass_kg - r.mass_before_kg
    rows = [
        (
            name,
            str(then) if then >= 0 else "-",
            str(now) if now >= 0 else "-",
            f"{1e3 * mass:+.4g}",
        )
        for name, then, now, mass in zip(r.candidate, r.shims_before, r.shims, change, strict=True)
        if abs(mass) > 1e-9
    ]
    if not rows:
        return ["no shim is changed"]
    total = f"{1e3 * np.abs(change).sum():.4g} g are added or taken away, at {count(len(rows), 'block')}"
    return [*table(("block", "shims before", "after", "change g"), rows, right=(1, 2, 3)), total]


def result_lines(r: BalanceResults, most: int | None) -> list[str]:
    """The same of a file that is there."""
    if r.mass_before_kg is not None:
        return _limit_lines(r, most) + _change_lines(r) + _blocking_lines(r)
    lines = _limit_lines(r, most)
    if r.price_kg.any():
        lines.append("costs: mass that 1 % more of the limit would save, where shims need not be whole")
    lines += _mass_lines(r)
    return lines + _blocking_lines(r) + _tolerance_lines(r) + _thermal_lines(r)


def _limit_lines(r: BalanceResults, most: int | None) -> list[str]:
    shown = [i for i in range(len(r.after)) if max(r.before[i].ratio, r.after[i].ratio) > _LISTED]
    shown.sort(key=lambda i: -max(r.before[i].ratio, r.after[i].ratio))
    head = (
        "at rest",
        "quantity",
        "subsystem",
        "limit",
        "before",
        "after",
        "ratio before",
        "after",
        "costs g/%",
        "verdict",
    )
    lines = table(head, [_row(r, i) for i in shown[:most]], right=(3, 4, 5, 6, 7, 8))
    if more := len(shown[:most]) < len(shown):
        lines.append(f"and {len(shown) - len(shown[:most])} more (--top 0: all)")
    if len(shown) < len(r.after):
        lines.append(f"{len(r.after) - len(shown)} {'more ' if more else ''}stay below {_LISTED:g} of their limits")
    return lines


def _row(r: BalanceResults, i: int) -> tuple[str, ...]:
    b, a = r.before[i], r.after[i]
    price = r.price_kg[i] * 10.0  # kg by the whole of a limit to g by a hundredth
    return (
        place_text(a.place),
        a.quantity,
        a.subsystem,
        f"{a.limit:.3g}",
        f"{b.value:.3e}",
        f"{a.value:.3e}",
        ratio_text(b.ratio) if b.ratio > 1e-6 else "0",
        ratio_text(a.ratio) if a.ratio > 1e-6 else "0",
        f"{price:.3g}" if price else "-",
        "pass" if a.passed else "FAIL",
    )


def _mass_lines(r: BalanceResults) -> list[str]:
    rows = [
        (box, f"{mass:.4g}", f"{relaxed:.4g}", f"{full:.4g}", _shims(r, box), _room(r, box))
        for box, (mass, relaxed, full) in r.by_box().items()
    ]
    lines = table(
        ("box", "kg", "relaxed kg", "holds kg", "shims of each part", "a kg more saves kg"), rows, right=(1, 2, 3, 5)
    )
    if r.has_steps:
        over = r.total_kg - r.total_relaxed_kg
        lines.append(
            f"whole shims: {r.total_kg:.5g} kg, {over:.3g} kg above the relaxed programme"
            f" ({r.total_relaxed_kg:.5g} kg); no whole shims can be below {r.bound_kg:.5g} kg"
        )
    if r.beyond:
        lines.append(f"whole shims leave the worst ratio {100 * r.beyond:.2g} % above what the programme allows")
    return lines


def _shims(r: BalanceResults, box: str) -> str:
    own = [int(n) for n, name in zip(r.shims, r.box, strict=True) if name == box]
    return " ".join(map(str, own)) if max(own) >= 0 else "-"


def _room(r: BalanceResults, box: str) -> str:
    most = max(float(v) for v, name in zip(r.room, r.box, strict=True) if name == box)
    return f"{most:.3g}" if most > 0.0 else "-"


def _blocking_lines(r: BalanceResults) -> list[str]:
    """Why limits are not met: what blocks what, and which box could help."""
    lines = []
    for number, ratio in enumerate(r.conflict_ratio, start=1):
        weight, beside = r.conflict_weight[number - 1], r.conflict_beside[number - 1]
        named = [f"{name_of(r.after[i])} ({100 * weight[i]:.3g} %)" for i in _ranked(weight)]
        also = [name_of(r.after[i]) for i in np.flatnonzero(r.blocking == number) if not weight[i]]
        held = [name_of(r.after[i]) for i in _ranked(beside)]
        together = " together" if len(named) > 1 else ""
        below = "be met" if ratio > 1.0 else "be met with the whole margin"
        lines.append(f"blocked: {and_text(named)} cannot {below}{together}: least worst ratio {ratio_text(ratio)}")
        lines += [f"  the same is true of {and_text(also)}"] if also else []
        lines += [f"  beside {and_text(held)}, as they were told of before"] if held else []
        lines.append(f"  {_help(r, number - 1)}")
    idle = sum(not reached and v.passed for v, reached in zip(r.after, r.reached, strict=True))
    if r.could_be_met + idle > r.met:
        lines.append(
            f'{r.could_be_met + idle} of {len(r.after)} could be met, with others worse: goal = "most met" does that'
        )
    for i, (v, reached) in enumerate(zip(r.after, r.reached, strict=True)):
        if not v.passed and reached:
            nearer = [f"{box} ({100 * gain:.2g} % of its limit by a gram)" for box, gain in r.helpful(i)]
            lines.append(f"{name_of(v)} is brought nearer by {and_text(nearer) or 'no box'}")
        if not v.passed and not reached:
            lines.append(
                f"not reached: {name_of(v)}, ratio {ratio_text(r.after[i].ratio)}: no box has mass that changes it"
            )
    return lines


def _tolerance_lines(r: BalanceResults) -> list[str]:
    """What tolerances take of the limits, and which share of drawn builds meets them."""
    lines = []
    if (found := r.tolerances) is not None:
        order = sorted(range(len(r.after)), key=lambda i: -r.off_ratio(i))[:5]
        rows = [
            (name_of(r.after[i]), f"{r.off_ratio(i):.3g}", found.largest(i)) for i in order if r.off_ratio(i) > _LISTED
        ]
        lines += table(("may be off", "of the limit", "most by"), rows, right=(1,)) if rows else []
        lines.append(
            f"room for {found.sigmas:g} standard deviations of {count(len(found.name), 'tolerance')}, {found.sum}"
        )
    if (y := r.drawn) is not None:
        lines.append(
            f"yield: {y.met} of {y.draws:,} builds drawn from the tolerances meet everything"
            f" ({100 * y.met / y.draws:.3g} %, 95 % interval {100 * y.low:.4g} to {100 * y.high:.4g} %);"
            f" against the exact field values are within {y.error:.1g} of their ranges"
        )
        worst = int(y.each.argmin())
        if y.each[worst] < 1.0:
            lines.append(f"  fewest meet {name_of(r.after[worst])}: {100 * y.each[worst]:.3g} %")
    return lines


def _thermal_lines(r: BalanceResults) -> list[str]:
    """What tied blocks add to the sensitivities."""
    if (price := r.thermal) is None:
        return ["no block is tied to the structure: none moves with temperatures"] if r.block else []
    alone, together = price.root_sum_squares, price.sums
    largest = np.argsort(-np.abs(alone[1] - alone[0]) / alone[0].max(), kind="stable")
    most = [i for i in largest if price.unit[i] == "m/s^2/K"][:2] + [i for i in largest if price.unit[i] != "m/s^2/K"][
        :1
    ]
    rows = [
        (
            price.row[i],
            price.unit[i],
            *(f"{alone[n, i]:.3e}" for n in (0, 1)),
            *(f"{together[n, i]:.3e}" for n in (0, 1)),
        )
        for i in most
    ]
    head = ("S_SG", "unit", "areas apart", "with blocks", "areas together", "with blocks")
    return [
        *table(head, rows, right=(2, 3, 4, 5)),
        "apart: root of the sum of squares over the areas; together: their sum",
    ]


def _ranked(weight: FloatArray) -> list[int]:
    """Rows with a weight, the largest first."""
    return [int(i) for i in np.argsort(-weight, kind="stable") if weight[i] > 0.0]


def _help(r: BalanceResults, conflict: int) -> str:
    gains: dict[str, float] = {}
    for name, value in zip(r.box, r.conflict_gain[conflict], strict=True):
        gains[name] = max(gains.get(name, 0.0), float(value))
    helping = sorted(((v, n) for n, v in gains.items() if v > 0.0), reverse=True)[:3]
    if helping:
        named = and_text([f"{name} (a kilogram more: ratio -{value:.3g})" for value, name in helping])
        return f"full boxes that would help if they held more: {named}"
    return "no box would help by holding more: mass is wanted in another place"


def name_of(v: DcVerdict) -> str:
    """`TM2 − TM1 a_x of IS`."""
    return f"{place_text(v.place)} {v.quantity} of {v.subsystem}"


def balance_dict(done: BalanceSummary) -> dict[str, Any]:
    """What a program needs."""
    return {"file": done.path, "csv": done.csv, **results_dict(done.results)}


def retrim_dict(done: RetrimSummary) -> dict[str, Any]:
    """The same of a re-trim."""
    r = done.results
    assert r.mass_before_kg is not None
    before = dict(zip(r.candidate, r.mass_before_kg, strict=True))
    return {"file": done.path, "csv": done.csv, "mass_before_kg": before, **results_dict(r)}


def results_dict(r: BalanceResults) -> dict[str, Any]:
    """What a file says."""
    return {
        "met": r.met,
        "passed": r.met == len(r.after),
        "mass_kg": r.total_kg,
        "relaxed_mass_kg": r.total_relaxed_kg,
        "bound_kg": r.bound_kg,
        "margin": r.margin,
        "requirements": [
            {
                "test_mass": a.test_mass,
                "minus": a.minus or None,
                "quantity": a.quantity,
                "subsystem": a.subsystem,
                "requirement": a.requirement,
                "lower": a.lower,
                "upper": a.upper,
                "unit": a.unit,
                "before": b.value,
                "after": a.value,
                "ratio_before": b.ratio,
                "ratio_after": a.ratio,
                "passed": a.passed,
                "reached": bool(reached),
                "conflict": int(blocking) or None,
                "price_kg": float(price),
                "off": float(off),
            }
            for b, a, blocking, reached, price, off in zip(
                r.before, r.after, r.blocking, r.reached, r.price_kg, r.off, strict=True
            )
        ],
        "conflicts": [
            {
                "ratio": float(ratio),
                "weight": {name: float(w) for name, w in zip(r.name, weight, strict=True) if w > 0.0},
            }
            for ratio, weight in zip(r.conflict_ratio, r.conflict_weight, strict=True)
        ],
        "candidates": [
            {"name": name, "box": box, "mass_kg": float(mass), "relaxed_kg": float(relaxed), "full_kg": float(full),
             "shims": None if shims < 0 else int(shims)}
            for name, box, mass, relaxed, full, shims in zip(
                r.candidate, r.box, r.mass_kg, r.relaxed_kg, r.full_kg, r.shims, strict=True
            )
        ],
        "blocks": [
            {"name": name, "mass_kg": float(mass), "centre_m": centre, "size_m": size, "group": group or None,
             "tied_to": tie or None}
            for name, mass, centre, size, group, tie in zip(
                r.block, r.block_kg, r.centre, r.size, r.group, r.tie, strict=True
            )
        ],
        "thermal": None
        if r.thermal is None
        else {
            "rows": r.thermal.row,
            "root_sum_squares": r.thermal.root_sum_squares,
            "sums": r.thermal.sums,
        },
        "yield": None
        if r.drawn is None
        else {"draws": r.drawn.draws, "met": r.drawn.met, "interval": [r.drawn.low, r.drawn.high]},
    }  # fmt: skip
