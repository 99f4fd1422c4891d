"""The least change of shims that brings a field within its limits again."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.balance.programme import Programme


def least_change(programme: Programme, before: FloatArray) -> Programme:
    """The programme whose mass is that which is added and taken away; behind the unknowns there are their changes.

    Of each unknown there is the magnitude of its change too, ``d >= |u - before|``, which alone has weight.

    Parameters
    ----------
    before : [c], numbers of units that there are.
    """
    count = len(before)
    one, none = np.eye(count), np.zeros((len(programme.effect), count))
    behind = np.zeros((len(programme.matrix), count))
    return replace(
        programme,
        effect=np.hstack([programme.effect, none]),
        unit_kg=np.append(np.zeros(count), programme.unit_kg),
        least=np.append(programme.least, np.zeros(count)),
        most=np.append(programme.most, programme.most),
        whole=np.append(programme.whole, np.zeros(count, dtype=bool)),
        matrix=np.vstack([np.hstack([programme.matrix, behind]), np.hstack([one, -one]), np.hstack([-one, -one])]),
        bound=np.concatenate([programme.bound, before, -before]),
    )
