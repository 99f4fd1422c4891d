"""What a read-out is made of as lines of text and as a plain dictionary."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from tedm_cli.cli.printing.table import table
from tedm_cli.optics.shares import SAME

if TYPE_CHECKING:
    from tedm_cli.optics.shares import SetComparison
    from tedm_cli.stages.explain.read_outs import Explanation, ReadOutExplained, Shares


_NOTES = {
    "plates": "plates, glass: what their index and thickness change, beside all motion",
    "effects": "effects: your own, by the tables of the model's configuration",
}


def explain_lines(done: Explanation, most: int | None) -> list[str]:
    """Bench as one against distortion, what the sets add to each other, and the largest shares of every read-out."""
    over = f"over {len(done.areas)} areas" if not done.load else f"for {_load(done)}"
    part = ", distortion of the bench alone" if done.distortion_only else ""
    lines = [f"{done.path}: read-out of set {done.set_name} {over}{part}", ""]
    beside = dict.fromkeys(part.name for r in done.read_outs for part in r.beside)
    rows = [
        (
            r.label,
            r.unit,
            f"{r.size:.3e}",
            f"{r.total:.3e}",
            f"{r.rigid_size:.3e}",
            f"{r.distortion_size:.3e}",
            _percent(r.rigid_share),
            _percent(_distortion_share(r)),
            *(text for part in beside for text in _beside(r, part)),
        )
        for r in done.read_outs
    ]
    added = [text for part in beside for text in (part, f"{part} %")]
    head = ("read-out", "unit", "size", "sum", "as one", "distortion", "as one %", "distortion %", *added)
    lines += [*table(head, rows, right=range(2, len(head))), *_comparison_lines(done)]
    for r in done.read_outs:
        lines += ["", f"== {r.label} ({r.unit})"]
        tables = [] if done.load else [_table("area", r.areas, most, r.value)]
        tables += [
            _table(name, s, most) for name, s in (("element", r.elements), ("motion", r.motions), ("beam", r.beams))
        ]
        if r.gradients:
            values = [(name, f"{value:.3e}") for name, value in r.gradients[:most]]
            tables.append(table(("gradient", r.unit.replace("/K", "/(K/m)")), values, right=(1,)))
        lines += [line for found in tables for line in ("", *found)]
    notes = ["gradients, per K/m, are in no size, sum or share"] if any(r.gradients for r in done.read_outs) else []
    return [
        *lines,
        "",
        "size: root of the sum of squares over the areas; sum: of all areas, the uniform load; share: of the variance",
        "for areas that fluctuate alike and independently (of one load: of its value), signed, those of a kind sum to",
        "100 %; as one: rigid motion of each bench nearest to its elements' motions, read as the opposite of the test",
        "masses; distortion: the rest; motions are along the axes of the layout, read-outs along those of each test",
        "mass",
        *(_NOTES[part] for part in beside),
        *notes,
    ]


def explain_dict(done: Explanation, most: int | None) -> dict[str, Any]:
    """What a program needs of it."""
    return {
        "file": str(done.path),
        "set": done.set_name,
        "condition": done.condition,
        "load": done.load or "every area",
        "load_unit": done.load_unit,
        "distortion_only": done.distortion_only,
        "read_outs": [_read_out_dict(r, most) for r in done.read_outs],
        "sets": [_comparison_dict(done, c) for c in done.comparisons],
    }


def _read_out_dict(r: ReadOutExplained, most: int | None) -> dict[str, Any]:
    return {
        "label": r.label,
        "unit": r.unit,
        "size": r.size,
        "sum": r.total,
        "rigid": {"share": r.rigid_share, "size": r.rigid_size},
        "distortion": {
            "share": _distortion_share(r),
            "size": r.distortion_size,
        },
        **{part.name: {"share": part.share, "size": part.size} for part in r.beside},
        "areas": [
            {"name": r.areas.label[i], "value": float(r.value[i]), "share": float(r.areas.share[i])}
            for i in r.areas.ranked(most)
        ],
        "gradients": [
            {"name": name, "value": value, "unit": r.unit.replace("/K", "/(K/m)")} for name, value in r.gradients[:most]
        ],
        **{
            key: [{"name": s.label[i], "size": float(s.size[i]), "share": float(s.share[i])} for i in s.ranked(most)]
            for key, s in (("elements", r.elements), ("motions", r.motions), ("beams", r.beams))
        },
    }


def _distortion_share(r: ReadOutExplained) -> float:
    return 1.0 - r.rigid_share - sum(part.share for part in r.beside)


def _beside(r: ReadOutExplained, name: str) -> tuple[str, str]:
    """Size and share of a part beside all motion; of a read-out that has none of it, dashes."""
    part = next((part for part in r.beside if part.name == name), None)
    return ("-", "-") if part is None else (f"{part.size:.3e}", _percent(part.share))


def _comparison_dict(done: Explanation, c: SetComparison) -> dict[str, Any]:
    columns = (*c.amplitudes, c.relative, c.mean, c.best, c.weight)
    keys = (f"size_{c.first}", f"size_{c.second}", "relative_difference", "size_of_mean", "size_of_best", "weight")
    return {
        "first": c.first,
        "second": c.second,
        "same": bool((c.relative < SAME).all()),
        "read_outs": [
            {"label": name, "unit": f"{unit}/K", **{k: float(v[i]) for k, v in zip(keys, columns, strict=True)}}
            for i, (name, unit) in enumerate(zip(done.names, done.units, strict=True))
        ],
    }


def _comparison_lines(done: Explanation) -> list[str]:
    """What each further set adds; sets that read the same are said to in one line."""
    lines: list[str] = []
    for c in done.comparisons:
        a, b = c.first, c.second
        if (c.relative < SAME).all():
            lines += [
                "",
                f"sets {a} and {b} read the same (to {c.relative.max():.1e}): for thermal distortion {b} adds nothing"
                f" to {a}, and their mean is as noisy as either",
            ]
            continue
        rows = [
            (
                name,
                f"{unit}/K",
                *(f"{v:.3e}" for v in (c.amplitudes[0][i], c.amplitudes[1][i])),
                _percent(c.relative[i]),
                f"{c.mean[i]:.3e}",
                f"{c.best[i]:.3e}",
                f"{c.weight[i]:.3g}",
            )
            for i, (name, unit) in enumerate(zip(done.names, done.units, strict=True))
        ]
        head = ("read-out", "unit", a, b, f"{a}-{b} %", "mean", "best", f"weight of {a}")
        better = np.minimum(*c.amplitudes)
        left = np.divide(c.best, better, out=np.ones_like(better), where=better > 0).min()
        lines += [
            "",
            f"sets {a} and {b} differ: their best weighted mean is at most {100 * (1 - left):.2g} % less noisy than"
            " the better one (sizes over all areas)",
            *table(head, rows, right=range(2, 8)),
        ]
    return lines


def _load(done: Explanation) -> str:
    return "the uniform load" if done.load == "uniform" else f"area {done.load}"


def _table(title: str, s: Shares, most: int | None, value: Any = None) -> list[str]:
    """The largest shares, with their values (signed) or sizes."""
    column = s.size if value is None else value
    rows = [(s.label[i], _percent(s.share[i]), f"{column[i]:.3e}") for i in s.ranked(most)]
    return table((title, "share %", "size" if value is None else "value"), rows, right=(1, 2))


def _percent(share: float) -> str:
    return f"{100 * share:.3g}"
