"""Why a criterion differs between two variants: the parts that its value is made of, compared one by one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

Parts = Mapping[str, float]


@dataclass(frozen=True)
class Change:
    """A part in the one variant and in the other; None where the variant has no such part."""

    name: str
    before: float | None
    after: float | None

    @property
    def difference(self) -> float:
        return (self.after or 0.0) - (self.before or 0.0)


def changes(before: Parts, after: Parts) -> list[Change]:
    """All parts of either, those that have changed most first; those that tie in the order of the first variant."""
    found = [Change(name, before.get(name), after.get(name)) for name in dict.fromkeys([*before, *after])]
    return sorted(found, key=lambda change: -abs(change.difference))


def largest_of_any(parts: Sequence[Parts], most: int) -> list[str]:
    """The names of the parts that are among the `most` largest of any variant, by their largest size first."""
    size: dict[str, float] = {}
    for of in parts:
        for name in sorted(of, key=lambda name: -abs(of[name]))[:most]:
            size[name] = max(size.get(name, 0.0), *(abs(other.get(name, 0.0)) for other in parts))
    return sorted(size, key=lambda name: -size[name])
