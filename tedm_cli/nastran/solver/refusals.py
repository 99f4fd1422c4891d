"""What the embedded solver does not model, refused by name in one message."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

from tedm_cli.errors import InputError
from tedm_cli.nastran.solver.solids import count_refused_solids

_HINT = "run Nastran on the written deck instead of the embedded solver"

_MODELLED = {
    "GRID",
    "CHEXA",
    "CPENTA",
    "CTETRA",
    "CBAR",
    "PSOLID",
    "PBAR",
    "MAT1",
    "MAT9",
    "MAT11",
    "RBE2",
    "RBE3",
    "SPC",
    "SPC1",
    "SPCADD",
    "TEMP",
    "TEMPD",
}
# Cards without influence on static thermal displacements: masses, coordinate systems (grids that use one are refused),
# plotting, sets, and loads that no subcase selects (a selection is refused).
_WITHOUT_INFLUENCE = {
    *("ENDDATA", "PARAM", "PLOTEL", "SET1", "SET3", "EIGR", "EIGRL"),
    *("CORD1R", "CORD1C", "CORD1S", "CORD2R", "CORD2C", "CORD2S"),
    *("CONM1", "CONM2", "CMASS1", "CMASS2", "CMASS3", "CMASS4", "PMASS", "NSM", "NSM1", "NSML", "NSML1", "NSMADD"),
    *("LOAD", "FORCE", "FORCE1", "FORCE2", "MOMENT", "MOMENT1", "MOMENT2", "PLOAD", "PLOAD1", "PLOAD2", "PLOAD4"),
    *("GRAV", "ACCEL", "ACCEL1", "RFORCE"),
}
# PBAR's shear factors default to zero in Nastran, "infinitely stiff"; pyNastran writes that as 1e8.
_RIGID_IN_SHEAR = 1e7


def refuse_unsupported(model: Any, path: Path) -> None:
    found: Counter[str] = Counter()
    for name, count in model.card_count.items():
        if name not in _MODELLED and name not in _WITHOUT_INFLUENCE:
            found[name] += count
    for grid in model.nodes.values():
        found["GRID with a position frame CP"] += grid.cp != 0
        found["GRID with a displacement frame CD"] += grid.cd != 0
    used = set()
    for element in model.elements.values():
        if element.type == "CBAR":
            found["CBAR with pin flags PA/PB"] += bool(element.pa or element.pb)
            found["CBAR with end offsets WA/WB"] += bool(np.any(element.wa) or np.any(element.wb))
            used.add(element.pid)
    count_refused_solids(model, found)
    for pid in used & model.properties.keys():
        prop = model.properties[pid]
        if prop.type == "PBAR":
            found["PBAR with shear factors K1/K2"] += any(0.0 < k < _RIGID_IN_SHEAR for k in (prop.k1, prop.k2))
    for element in model.rigid_elements.values():
        found[f"{element.type} with thermal expansion ALPHA"] += bool(element.alpha)
        found["RBE3 with moved dependents UM"] += element.type == "RBE3" and bool(element.Gmi)
    for constraints in model.spcs.values():
        for one in constraints:
            found["SPC with a displacement other than zero"] += one.type == "SPC" and any(one.enforced)
    inertia_relief = model.params.get("INREL")
    found["PARAM INREL"] += inertia_relief is not None and inertia_relief.values[0] != 0
    refused = [f"{name} ({count})" for name, count in sorted(found.items()) if count]
    if refused:
        raise InputError(f"not modelled by the embedded solver: {', '.join(refused)}", where=str(path), hint=_HINT)
