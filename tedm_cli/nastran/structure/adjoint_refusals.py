"""What has no thermal coupling here, by ids: an adjoint of part of a model would be wrong without saying where."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tedm_cli.documentation import Page
from tedm_cli.errors import InputError
from tedm_cli.nastran.bulk.columns import columns_of
from tedm_cli.nastran.geometry import id_list
from tedm_cli.nastran.loads.temperatures import temperature_dependent

_PROPERTIES = {
    **dict.fromkeys(("CHEXA", "CPENTA", "CTETRA"), ("PSOLID",)),
    **dict.fromkeys(("CQUAD4", "CTRIA3"), ("PSHELL",)),
    "CBAR": ("PBAR", "PBARL"),
    "CBEAM": ("PBEAM", "PBEAML"),
    "CROD": ("PROD",),
    "CONROD": (),
    "CTUBE": ("PTUBE",),
}
_RIGID = ("RBE2", "RBE3", "RBAR")
_HINT = f"{Page.SOLVER} lists its cards, and their forms"


def refuse_without_coupling(model: Any, path: Path) -> None:
    """Refuse elements of other kinds, rigid elements that expand, and properties that depend on temperature.

    Parameters
    ----------
    model : pyNastran model, not cross-referenced, of the deck whose main file is `path`.

    Raises
    ------
    InputError : all of them by card and id. Features of the cards that are left are refused by `solver_structure`.
    """
    found: dict[str, list[int]] = {}
    columns = columns_of(model)
    for group, element in enumerate(columns.examples()):
        known = _PROPERTIES.get(element.type)
        name = ""
        if known is None:
            name = element.type
        elif known and (own := model.properties.get(element.pid)) is not None and own.type not in known:
            name = f"{element.type} of {own.type}"
        if name:
            found.setdefault(name, []).extend(columns.element.id[columns.alike.number == group].tolist())
    found = {name: sorted(ids) for name, ids in found.items()}
    for number, element in sorted(model.rigid_elements.items()):
        if element.type not in _RIGID:
            found.setdefault(element.type, []).append(number)
        elif getattr(element, "alpha", 0.0):
            found.setdefault(f"{element.type} that expands (ALPHA)", []).append(number)
    facts = [f"{card} {id_list(ids)}" for card, ids in found.items()]
    facts += [f"{name}, which depends on temperature" for name in temperature_dependent(model)]
    if facts:
        raise InputError(f"the adjoint has no thermal coupling of: {'; '.join(facts)}", where=str(path), hint=_HINT)
