"""Outputs as loads of a deck: their forces and moments in its units, and labels that tell the scale of each.

The load of a subcase is g over a number, so that its largest force is about 1 in any unit. The number is in the LABEL,
which results repeat: displacements times it are the solution λ of K λ = g.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tedm_cli.area_names import LONGEST
from tedm_cli.arrays import FloatArray
from tedm_cli.deck_units import FORCE, DeckUnits
from tedm_cli.errors import InputError

_LABEL = re.compile(r"(\S+) SCALE (\d\.\d{5}E[+-]\d{2,3})", re.IGNORECASE)
#: Over the largest, what is left out: solvers whose words have 32 bits take it for zero anyway.
_SMALLEST = 1e-30


@dataclass(frozen=True, eq=False)
class AdjointRow:
    """One output as a load on the N grids of a deck.

    output : its name. scale : by which displacements in m and rad are the solution, in the unit of the output over N
    and N·m. load : [N, 6], forces and moments, basic frame, in the deck's units.
    """

    output: str
    scale: float
    load: FloatArray

    @property
    def label(self) -> str:
        """LABEL of its subcase."""
        return f"{self.output} SCALE {_written(self.scale)}"


def adjoint_rows(outputs: Sequence[str], force: FloatArray, units: DeckUnits, where: str) -> list[AdjointRow]:
    """The outputs as loads of a deck in these units; those that nothing acts on, whose forces are zero, are left out.

    Parameters
    ----------
    outputs : [r], names without blanks.
    force : [6 N, r], their nodal forces and moments by m and rad of the degrees of freedom, SI, basic frame.
    where : for messages.

    Raises
    ------
    InputError : names that are too long for a LABEL, or differ in their case alone.
    """
    rows = []
    newton, metre = units.factor(FORCE), units.length_m
    for output, column in zip(outputs, force.T, strict=True):
        load = column.reshape(-1, 6) / np.repeat([1.0, metre], 3)
        largest = np.abs(load).max()
        if largest > 0.0:
            scale = float(_written(largest / newton))
            load = load / (scale * newton)
            rows.append(AdjointRow(output, scale, np.where(np.abs(load) > _SMALLEST, load, 0.0)))
    _check_labels(rows, where)
    return rows


def read_label(label: str) -> tuple[str, float] | None:
    """Name of the output and scale that a LABEL tells; None of another label."""
    found = _LABEL.fullmatch(label)
    return None if found is None else (found[1], float(found[2]))


def _written(scale: float) -> str:
    return f"{scale:.5E}"


def _check_labels(rows: Sequence[AdjointRow], where: str) -> None:
    long = [row.output for row in rows if len(row.label) > LONGEST]
    if long:
        most = LONGEST - len(rows[0].label) + len(rows[0].output)
        raise InputError(
            f"output {long[0]} has a name of {len(long[0])} characters, and a LABEL has room for {most}",
            where=where,
            hint="give test masses and sets of photodiodes shorter names",
        )
    seen: dict[str, str] = {}
    for row in rows:
        if seen.setdefault(row.output.upper(), row.output) != row.output:
            raise InputError(
                f"outputs {seen[row.output.upper()]} and {row.output} differ in their case alone, which labels of"
                " Nastran do not tell apart",
                where=where,
                hint="rename a test mass, or a set of photodiodes",
            )
