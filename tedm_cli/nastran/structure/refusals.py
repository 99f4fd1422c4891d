"""What the embedded solver does not model, refused by name in one message."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

from tedm_cli.errors import InputError
from tedm_cli.nastran.bulk.columns import columns_of
from tedm_cli.nastran.card_names import ELEMENT_TEMPERATURES, WITHOUT_INFLUENCE
from tedm_cli.nastran.parameter_values import parameter
from tedm_cli.nastran.structure.line_shell_refusals import line_refusals, rigid_refusals, shell_refusals
from tedm_cli.nastran.structure.mechanical_loads import LOAD_CARDS
from tedm_cli.nastran.structure.solids import count_refused_solids

_HINT = "run Nastran on the written deck instead of the embedded solver"

_MODELLED = {
    "GRID",
    "CHEXA",
    "CPENTA",
    "CTETRA",
    "PSOLID",
    *("CBAR", "PBAR", "PBARL", "CBEAM", "PBEAM", "PBEAML"),
    *("CROD", "PROD", "CONROD", "CTUBE", "PTUBE"),
    *("CQUAD4", "CTRIA3", "PSHELL"),
    *("CORD1R", "CORD1C", "CORD1S", "CORD2R", "CORD2C", "CORD2S"),
    "MAT1",
    *("MAT9", "MAT11"),
    *("RBE2", "RBE3", "RBAR", "MPC", "MPCADD"),
    "SPC",
    "SPC1",
    "SPCADD",
    "TEMP",
    "TEMPD",
    *ELEMENT_TEMPERATURES,
    *LOAD_CARDS,
}
# Cards without influence on static displacements: masses (of accelerations they are read beside the structure),
# plotting, sets, scalar points (what could be on them is refused), other solutions, and loads that no subcase selects
# (a selection is refused).
_WITHOUT_INFLUENCE = {
    *WITHOUT_INFLUENCE,
    *("FREQ", "FREQ1", "FREQ2", "FREQ3", "FREQ4", "FREQ5", "TABDMP1", "TSTEP", "EIGB", "EIGC", "DTI", "MONPNT1"),
    *("DLOAD", "RLOAD1", "RLOAD2", "TLOAD1", "TLOAD2", "DAREA", "DELAY", "DPHASE", "TABLED1", "TABLED2", "TABLED3"),
    *("TABLED4", "TABRND1", "RANDPS", "RANDT1", "DESVAR", "DRESP1", "DRESP2", "DCONSTR", "DOPTPRM"),
    *("ENDDATA", "PARAM", "SPOINT", "PLOTEL", "SET1", "SET3", "EIGR", "EIGRL"),
    *("CONM1", "CONM2", "CMASS1", "CMASS2", "CMASS3", "CMASS4", "PMASS", "NSM", "NSM1", "NSML", "NSML1", "NSMADD"),
    *("FORCE1", "FORCE2", "MOMENT1", "MOMENT2", "PLOAD", "PLOAD1", "PLOAD2", "PLOAD4", "ACCEL", "ACCEL1", "RFORCE"),
    "DMIG",  # K2GG and P2G are read, and what else could select one for statics is refused
    *("MAT4", "MAT5", "MATT4", "MATT5"),  # conduction, which `map-temperatures` reads
}


def refuse_unsupported(model: Any, path: Path) -> None:
    found: Counter[str] = Counter()
    for name, count in model.card_count.items():
        if name not in _MODELLED and name not in _WITHOUT_INFLUENCE:
            found[name] += count
    elements = columns_of(model).element
    used = set(np.unique(np.where(elements.is_of(["CONROD"]), 0, elements.property_id)).tolist())
    count_refused_solids(model, found)
    found.update(line_refusals(model, used))
    found.update(shell_refusals(model, used))
    found.update(rigid_refusals(model))
    for equations in model.mpcs.values():
        for one in equations:
            found["MPC with a scalar point"] += not model.spoints.keys().isdisjoint(one.nodes)
    found["PARAM INREL"] += parameter(model, "INREL", str(path)) not in (None, "0")
    refused = [f"{name} ({count})" for name, count in sorted(found.items()) if count]
    if refused:
        raise InputError(f"not modelled by the embedded solver: {', '.join(refused)}", where=str(path), hint=_HINT)
