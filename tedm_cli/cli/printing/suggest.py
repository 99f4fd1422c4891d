"""Suggested areas as lines of text."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.cli.printing.table import table

if TYPE_CHECKING:
    from tedm_cli.stages.adjoint.suggest import Suggestion

_SHARE = 0.005  # a smaller part would be told as 0 %


def suggestion_lines(done: Suggestion, top: int | None) -> list[str]:
    """Error against count, what the present areas leave out and where, and what was written."""
    lengths = [f"{mm:g} mm" for mm in done.length_mm]
    rows = [(f"{done.n_present} now", *_errors(done.present.ratio), _percent(_worst(done.present.ratio)))]
    for count in done.counts:
        ratio = done.merged.ratio_at(count)
        rows.append((f"{count:,}{' *' if count == done.count else ''}", *_errors(ratio), _percent(_worst(ratio))))
    outputs = ", ".join(done.field.outputs)
    field = "the same amplitude everywhere" if done.even else "amplitudes as the temperatures of the cases"
    lines = [
        f"what areas make of the standard deviation of {outputs},",
        f"against that of a field that decorrelates as exp(-d/ℓ), {field}; largest error:",
        *table(("areas", *(f"ℓ {length}" for length in lengths), "worst"), rows, right=range(len(lengths) + 2)),
    ]
    coarse = done.coarsest(top)
    if coarse:
        _, output, mm, _ = coarse[0]
        left = done.present.difference.max()
        named = ", ".join(f"{name} {100 * share:.0f} %" for name, _, _, share in coarse if share >= _SHARE)
        lines.append(
            f"the {done.n_present} areas leave out most of {output} at ℓ = {mm:g} mm, {100 * left:.0f} % of it;"
            f" parts of the variance of that: {named}"
        )
    if done.enough:
        lines.append(f"the {done.n_present} present areas are enough")
    if done.path is not None:
        follows = f": {done.path}, for areas_csv in [model]"
    else:
        follows = "; -o writes them for areas_csv" if done.new else ""
    lines.append(f"* {done.count} areas, {_new(done)}{follows}")
    return lines + [f"note: {note}" for note in done.notes]


def _new(done: Suggestion) -> str:
    """How many of the areas are new, and their sizes."""
    if not done.new:
        return "those that there are"
    few, most = min(done.new), max(done.new)
    sizes = f"{few:,} to {most:,}" if most > few else f"{few:,}"
    return f"{len(done.new)} of them new, of {sizes} grids"


def _worst(ratio: FloatArray) -> float:
    error = ratio.ravel() - 1.0
    return float(error[np.abs(error).argmax()])


def _errors(ratio: FloatArray) -> list[str]:
    return [_percent(_worst(row)) for row in ratio]


def _percent(value: float) -> str:
    return f"{100 * value:+.1f} %" if abs(value) >= 0.5e-3 else "0.0 %"
