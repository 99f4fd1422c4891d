"""Law of one set of photodiodes on the measured degrees of freedom, its inverse, and what the set cannot read."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from tedm_cli.arrays import FloatArray
from tedm_cli.errors import PhysicsError
from tedm_cli.optics.labels import read_out_labels
from tedm_cli.optics.layout import OpticalLayout

#: Singular values up to this fraction of the largest one count as zero; tolerates matrices printed with seven digits.
RANK_TOLERANCE = 1e-6
_LOST = 1e-3  # entry of the projector onto the null space from which a degree of freedom belongs to it


@dataclass(frozen=True, eq=False)
class ReadOutInverse:
    """Law of one set on the measured degrees of freedom, and its (least-squares) inverse.

    They are those of each test mass on its own axes.
    `O` [3 * n_pd, n_dof] (m, rad by m, rad), `inverse` [n_dof, 3 * n_pd], `condition` in the 2-norm of those units.
    """

    O: FloatArray  # noqa: E741 - the matrix has this name in the field
    inverse: FloatArray
    singular_values: FloatArray
    condition: float


def read_out_inverse(layout: OpticalLayout, set_name: str, PS: FloatArray) -> ReadOutInverse:
    """Law of the set `set_name` on the measured degrees of freedom, and its inverse.

    Parameters
    ----------
    PS : P S_BW, [3 * n_pd, 6 * n_elements].

    Raises
    ------
    PhysicsError : the set cannot tell all measured degrees of freedom apart; those lost are named.
    """
    law = PS[layout.laser_rows(layout.sets[set_name])] @ layout.read_out_motions
    left, singular, right = np.linalg.svd(law, full_matrices=True)
    n_dof = law.shape[1]
    values = np.zeros(n_dof)
    values[: singular.size] = singular
    n_lost = int(np.count_nonzero(values <= RANK_TOLERANCE * values[0]))
    if n_lost:
        raise PhysicsError(
            f"the read-out matrix has rank {n_dof - n_lost} for {n_dof} degrees of freedom: the set "
            + "; it ".join(lost_degrees_of_freedom(layout, law, n_lost)),
            where=f"read-out set {set_name} ({', '.join(layout.sets[set_name])})",
            hint="give the set a photodiode of every interferometer, or measure fewer degrees of freedom",
        )
    inverse = right.T @ (left[:, :n_dof].T / values[:, None])
    return ReadOutInverse(law, inverse, values, float(values[0] / values[-1]))


def lost_degrees_of_freedom(layout: OpticalLayout, law: FloatArray, n_lost: int) -> list[str]:
    """What a law [3 * n_pd, n_dof] with an `n_lost`-dimensional null space does not read, in words.

    Degrees of freedom belong together where the projector onto the null space joins them, which needs no choice of a
    basis. One alone is not seen at all; of several only combinations are. Lengths are measured in the layout's size, so
    that levers of decimetres weigh as much as angles.
    """
    labels = read_out_labels(layout)
    scale = np.array([layout.size_m if unit == "m" else 1.0 for unit in labels.units])
    null = np.linalg.svd(law * scale, full_matrices=True)[2][-n_lost:]
    joined = np.abs(null.T @ null) > _LOST
    count, group = scipy.sparse.csgraph.connected_components(joined, directed=False)
    unseen, mixed = [], []
    for number in range(count):
        members = np.flatnonzero(group == number)
        names = [labels.names[i] for i in members]
        if len(members) > 1:
            apart = f"{names[0]} from {names[1]}" if len(names) == 2 else f"{_listed(names)} apart"
            mixed.append(f"cannot tell {apart} ({_hidden(names, null[:, members], scale[members])})")
        elif joined[members[0], members[0]]:
            unseen += names
    return ([f"does not see {_listed(unseen)}"] if unseen else []) + mixed


def _listed(names: list[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


def _hidden(names: list[str], null: FloatArray, scale: FloatArray) -> str:
    """How much of several degrees of freedom is not seen, `null` [n_lost, n] being their part of the null space."""
    dimension = round(float(np.sum(null**2)))  # trace of the projector
    if dimension > 1:
        return f"{dimension} combinations change nothing"
    return f"{_combination(names, np.linalg.svd(null)[2][0] * scale)} changes nothing"


def _combination(names: list[str], v: FloatArray) -> str:
    """A motion as text, its first component 1 (m, rad), e.g. ``TM1_x - 0.5 TM2_x``."""
    terms = [names[0]]
    for name, value in zip(names[1:], v[1:] / v[0], strict=True):
        size = f"{abs(value):.3g}"
        terms.append(f"{'-' if value < 0 else '+'} {'' if size == '1' else size + ' '}{name}")
    return " ".join(terms)
