"""Mass that case control adds by matrices (DMIG): nothing here weighs it, so it is refused.

A mass matrix has no place: between grids it moves mass from one to the other as the structure bends, and from where
gravity pulls on it follows from no rigid motion alone.
"""

from __future__ import annotations

from typing import Any

from tedm_cli.errors import InputError

_MASSES = ("M2GG", "M2PP")


def refuse_matrices(model: Any, where: str) -> None:
    """Refuse matrices by which a model weighs more than its elements.

    Raises
    ------
    InputError : M2GG or M2PP, with its subcase.
    """
    control = model.case_control_deck
    for number, subcase in [] if control is None else sorted(control.subcases.items()):
        for name in _MASSES:
            if name in subcase.params:
                raise InputError(
                    f"{subcase.params[name]}: mass of a matrix (DMIG) is not weighed, so it would be missing",
                    where=f"{where}: subcase {number}" if number else where,
                    hint=f"write the mass as CONM2 at its grids, and remove {name}",
                )
