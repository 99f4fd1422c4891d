"""The outputs of a model: what each of them becomes per kelvin of each thermal area."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.errors import InputError
from tedm_cli.noise.areas import AreaTable
from tedm_cli.noise.contributions import ReadOutParts
from tedm_cli.noise.differences import rows_of, terms
from tedm_cli.noise.effects import Effects
from tedm_cli.noise.requirements import UNITS, AppliedRequirement


@dataclass(frozen=True, eq=False)
class Outputs:
    """n_out outputs as rows per kelvin.

    Parameters
    ----------
    areas : the k thermal areas of the columns.
    rows : [n_out, k], unit of the output per kelvin.
    labels, kinds : [n_out], name and quantity (a key of `UNITS`) of each output.
    parts_of_read_outs : by label of a read-out, what it is made of; of an acceleration, too, where there are effects.
    effects : of the user's own, which are in the rows; None: none.
    benches : number of optical benches that they are of.

    Raises
    ------
    InputError : the shapes disagree, a sensitivity is not finite, or a quantity is unknown.
    """

    areas: AreaTable
    rows: FloatArray
    labels: tuple[str, ...]
    kinds: tuple[str, ...]
    parts_of_read_outs: Mapping[str, ReadOutParts] = field(default_factory=dict)
    benches: int = field(default=0, kw_only=True)
    effects: Effects | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        if self.rows.shape != (len(self.labels), len(self.areas)) or len(self.kinds) != len(self.labels):
            fact = (
                f"{self.rows.shape} for {len(self.labels)} labels, {len(self.kinds)} quantities"
                f" and {len(self.areas)} thermal areas"
            )
            raise InputError(f"sensitivities have shape {fact}", where="noise")
        bad = np.flatnonzero(~np.isfinite(self.rows).all(axis=1))
        if bad.size:
            fact = f"the sensitivity of {self.labels[bad[0]]} has values that are not finite"
            raise InputError(fact, where="noise")
        unknown = sorted(set(self.kinds) - UNITS.keys())
        if unknown:
            raise InputError(f"quantity {unknown[0]!r}; known: {', '.join(UNITS)}", where="noise")

    @property
    def units(self) -> tuple[str, ...]:
        """[n_out], of the outputs; amplitude spectral densities are in this unit per √Hz."""
        return tuple(UNITS[kind] for kind in self.kinds)

    def with_differences(self, requirements: Sequence[AppliedRequirement]) -> Self:
        """With the differences that the requirements judge, last: rows g_1 - g_2, so that common noise cancels.

        A difference whose terms do not exist, or are of different quantities, is left out: the requirement then names
        an output that there is not.
        """
        place = {label: o for o, label in enumerate(self.labels)}
        pairs: dict[str, tuple[str, str]] = {}
        for label in dict.fromkeys(label for applied in requirements for label in applied.outputs):
            pair = terms(label)
            if label in place or pair is None or pair[0] not in place or pair[1] not in place:
                continue
            if self.kinds[place[pair[0]]] == self.kinds[place[pair[1]]]:
                pairs[label] = pair
        parts = dict(self.parts_of_read_outs)
        for label, (first, second) in pairs.items():
            if first in parts and second in parts:
                parts[label] = parts[first] - parts[second]
        of_pairs = [(place[i], place[j]) for i, j in pairs.values()]
        return replace(
            self,
            effects=None if self.effects is None else self.effects.with_differences(of_pairs),
            rows=rows_of((*self.labels, *pairs), dict(zip(self.labels, self.rows, strict=True))),
            labels=(*self.labels, *pairs),
            kinds=(*self.kinds, *(self.kinds[place[i]] for i, _ in pairs.values())),
            parts_of_read_outs=parts,
        )
