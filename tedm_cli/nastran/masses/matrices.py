"""Matrices that case control adds to those of the elements (DMIG): what they weigh, and whether all subcases have them.

A mass matrix has no place: between grids it moves mass from one to the other as the structure bends, and what it
weighs follows from no rigid motion alone. It is refused, not weighed.
"""

from __future__ import annotations

from typing import Any

from tedm_cli.errors import InputError

_MASSES = ("M2GG", "M2PP")
_STIFFNESSES = ("K2GG", "A2GG")


def refuse_matrices(model: Any, where: str) -> None:
    """Refuse matrices by which a model weighs more, or its subcases are of different structures.

    Raises
    ------
    InputError : M2GG or M2PP; K2GG or A2GG that is not the same in all subcases.
    """
    control = model.case_control_deck
    subcases = {} if control is None else control.subcases
    for number, subcase in sorted(subcases.items()):
        place = f"{where}: subcase {number}" if number else where
        for name in _MASSES:
            if name in subcase.params:
                raise InputError(
                    f"{subcase.params[name]}: mass of a matrix (DMIG) is not weighed, so it would be missing",
                    where=place,
                    hint=f"write the mass as CONM2 at its grids, and remove {name}",
                )
    for name in _STIFFNESSES:
        chosen = {n: str(s.params[name]) if name in s.params else "none" for n, s in subcases.items() if n}
        if len(set(chosen.values())) > 1:
            listed = ", ".join(f"{v} in subcase {n}" for n, v in sorted(chosen.items())[:8])
            raise InputError(f"the subcases have different {name}: {listed}", where=where)
