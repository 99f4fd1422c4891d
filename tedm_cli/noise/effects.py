"""Effects of temperature on the outputs that no matrix of the chain has: named rows per kelvin, added coherently."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.noise.contributions import ReadOutParts

#: What the rest of an acceleration is, beside the effects.
SELF_GRAVITY = "self-gravity"


@dataclass(frozen=True, eq=False)
class Effects:
    """Effects by name, [e]; rows : [e, n_out, k], what each makes of every output per kelvin of every area."""

    names: tuple[str, ...]
    rows: FloatArray

    @property
    def part_names(self) -> tuple[str, ...]:
        """Their names as parts of an output, beside elements that move: `radiometer effect`."""
        return tuple(f"{name} effect" for name in self.names)

    @property
    def total(self) -> FloatArray:
        """All of them together, [n_out, k]."""
        return np.asarray(self.rows.sum(axis=0))

    def with_differences(self, pairs: Sequence[tuple[int, int]]) -> Effects:
        """With the differences of pairs of outputs, last."""
        more = [self.rows[:, i] - self.rows[:, j] for i, j in pairs]
        return replace(self, rows=np.stack([*np.moveaxis(self.rows, 1, 0), *more], axis=1))

    def and_silent(self, more: int) -> Effects:
        """With areas behind the others that no effect follows."""
        return replace(self, rows=np.pad(self.rows, ((0, 0), (0, 0), (0, more))))

    def added_to(
        self, labels: Sequence[str], rows: FloatArray, parts: Mapping[str, ReadOutParts]
    ) -> tuple[FloatArray, dict[str, ReadOutParts]]:
        """Rows [n_out, k] of outputs and what they are made of, with the effects.

        All parts get the names of all, so that outputs compare; of outputs without parts, accelerations, the rest is
        `SELF_GRAVITY`. Where no effect is on any of these, they stay without.
        """
        if not self.names:
            return rows, dict(parts)
        known = next((p.names for p in parts.values()), ())
        forces = [i for i, label in enumerate(labels) if label not in parts]
        asked = bool(np.any(self.rows[:, forces]))
        names = (*known, *([SELF_GRAVITY] if asked else []), *self.part_names)
        found: dict[str, ReadOutParts] = {}
        for i, label in enumerate(labels):
            of = parts.get(label)
            if of is None and not asked:
                continue
            own = np.zeros((len(names), rows.shape[1]))
            if of is None:
                own[len(known)] = rows[i]
            else:
                own[: len(known)] = of.by_element
            own[len(names) - len(self.names) :] = self.rows[:, i]
            rest = None if of is None or of.distortion is None else of.distortion + self.total[i]
            found[label] = ReadOutParts(names, own, rest)
        return rows + self.total, found
