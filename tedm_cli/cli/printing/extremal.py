"""The correlations at the bounds of a case, as lines of text."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from tedm_cli.cli.printing.table import table

if TYPE_CHECKING:
    from tedm_cli.stages.exports.extremal import Extremal


def extremal_lines(done: Sequence[Extremal]) -> list[str]:
    """A table of what was written, and how to run it."""
    rows = [
        (
            e.output,
            e.bound,
            f"{e.amplitude:.3g}",
            f"{e.of_case:.3g}",
            f"{e.unit}/sqrt(Hz)",
            f"{1e3 * e.frequency_hz:.3g}",
            e.id,
        )
        for e in done
    ]
    folder = done[0].path.parent
    head = ("output", "bound", "noise", "in case", "unit", "at mHz", "case id")
    if not done[0].id:
        return [
            *table(head[:-1], [row[:-1] for row in rows], right=(2, 3, 5)),
            f"{len(done)} matrices in {folder}: correlations of the nodes' temperatures, whose spectra stay those of"
            " the network; no case takes them",
        ]
    return [
        *table(head, rows, right=(2, 3, 5)),
        f"{len(done)} matrices and cases.toml in {folder}; to run them: append cases.toml to your cases file, then"
        f" `tedm run-case {done[-1].id}`",
    ]


def extremal_dict(done: Sequence[Extremal]) -> list[dict[str, Any]]:
    """What a program needs of each."""
    return [
        {
            "file": e.path,
            "case": e.id,
            "output": e.output,
            "bound": e.bound,
            "frequency_hz": e.frequency_hz,
            "noise": e.amplitude,
            "noise_in_case": e.of_case,
            "unit": f"{e.unit}/sqrt(Hz)",
        }
        for e in done
    ]
