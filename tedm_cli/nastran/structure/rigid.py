"""Rigid and interpolation elements of a deck."""

from __future__ import annotations

from typing import Any

import numpy as np

from tedm_cli.fem.structure import Rbe2, Rbe3
from tedm_cli.nastran.structure.references import CardReferences


def read_rigid_elements(model: Any, references: CardReferences) -> tuple[tuple[Rbe2, ...], tuple[Rbe3, ...]]:
    rbe2, rbe3 = [], []
    for eid, element in sorted(model.rigid_elements.items()):
        who = f"{element.type} {eid}"
        if element.type == "RBE2":
            rbe2.append(
                Rbe2(
                    element_id=int(eid),
                    independent=int(references.rows(element.gn, who)),
                    dependents=references.rows(element.Gmi, who),
                    components=str(element.cm),
                )
            )
        elif element.type == "RBAR":
            rbe2.append(_rigid_bar(element, references))
        else:
            counts = [len(grids) for grids in element.Gijs]
            rbe3.append(
                Rbe3(
                    element_id=int(eid),
                    dependent=int(references.rows(element.refgrid, who)),
                    components=str(element.refc),
                    independents=references.rows(np.concatenate(element.Gijs), who),
                    weights=np.repeat(np.asarray(element.weights, dtype=np.float64), counts),
                    independent_components=tuple(
                        str(digits) for digits, count in zip(element.comps, counts, strict=True) for _ in range(count)
                    ),
                )
            )
    return tuple(rbe2), tuple(rbe3)


def leading_end(bar: Any) -> str | None:
    """The end of an RBAR, "a" or "b", that has all six independent freedoms; None where they are spread over both."""
    if set(bar.cna) == set("123456") and not bar.cnb:
        return "a"
    return "b" if set(bar.cnb) == set("123456") and not bar.cna else None


def _rigid_bar(bar: Any, references: CardReferences) -> Rbe2:
    who = f"RBAR {bar.eid}"
    ends = (bar.ga, bar.gb, bar.cmb) if leading_end(bar) == "a" else (bar.gb, bar.ga, bar.cma)
    return Rbe2(
        element_id=int(bar.eid),
        independent=int(references.rows(ends[0], who)),
        dependents=references.rows([ends[1]], who),
        components=str(ends[2] or "123456"),
        kind="RBAR",
    )
