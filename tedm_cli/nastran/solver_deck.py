"""Read the part of Nastran that the embedded solver understands; refuse the rest by name.

The deck is a SOL 101 run whose subcases each apply one temperature set. Everything that would change the displacements
and is not modelled is collected first and refused in one message.
"""

from __future__ import annotations

from collections import Counter
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np

from tedm_cli.errors import InputError
from tedm_cli.fem.structure import BarBlock, Floats, HexBlock, Ints, LoadCase, Rbe2, Rbe3, Structure
from tedm_cli.nastran.reading import any_encoding
from tedm_cli.nastran.solver_cases import read_load_cases, selected_sets

_HINT = "run Nastran on the written deck instead of the embedded solver"

_MODELLED = {
    "GRID",
    "CHEXA",
    "CBAR",
    "PSOLID",
    "PBAR",
    "MAT1",
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


def read_solver_deck(path: Path) -> tuple[Structure, list[LoadCase]]:
    """Read a unit-load deck for the embedded solver.

    Parameters
    ----------
    path : the main file of the deck, with case control; includes are followed.

    Returns
    -------
    The structure, grids sorted by id, in the units and the basic frame of the deck, and one load case per subcase.

    Raises
    ------
    InputError
        If the file cannot be read; if it holds cards or features that are not modelled (all are named, with counts);
        if cards refer to what does not exist; or if subcases are not thermal or differ in their constraints.
    """
    model = _read(path)
    _refuse_unsupported(model, path)
    grid_id, position = _grids(model)
    if not any(element.type in ("CHEXA", "CBAR") for element in model.elements.values()):
        raise InputError(
            "no CHEXA and no CBAR elements", where=str(path), hint="a unit-load deck holds the whole model"
        )
    finder = _Finder(grid_id, path)
    hexes, bars = _hexes(model, finder), _bars(model, finder, position)
    rbe2, rbe3 = _rigid_elements(model, finder)
    sets = selected_sets(model, path)
    if sets.constraint is not None and not {sets.constraint} & (model.spcs.keys() | model.spcadds.keys()):
        raise InputError(f"case control selects SPC {sets.constraint}, which is not in the bulk data", where=str(path))
    spc_grid, spc_component = _constraints(model, sets.constraint, finder)
    finder.refuse_missing()

    heated = np.zeros(len(grid_id), dtype=bool)
    heated[hexes.connectivity.reshape(-1)] = True
    heated[bars.connectivity.reshape(-1)] = True
    initial, cases = read_load_cases(model, sets, grid_id, heated, path)
    structure = Structure(
        grid_id=grid_id,
        position=position,
        hexes=hexes,
        bars=bars,
        rbe2=rbe2,
        rbe3=rbe3,
        spc_grid=spc_grid,
        spc_component=spc_component,
        initial_temperature=initial,
    )
    return structure, cases


def _read(path: Path) -> Any:
    from cpylog import SimpleLogger  # type: ignore[import-untyped]
    from pyNastran.bdf.bdf import BDF

    if not path.is_file():
        raise InputError("no such file", where=str(path), hint="write it with `tedm write-deck`")
    model = BDF(log=SimpleLogger(level="critical"))
    dump = Path("pyNastran_crash.bdf")
    is_ours = not dump.exists()
    try:
        with redirect_stdout(StringIO()):  # pyNastran prints the cards that it cannot parse
            model.read_bdf(str(path), xref=False, validate=False, encoding=any_encoding(model))
    except Exception as error:  # of many kinds; all mean that the deck is not readable
        if is_ours:  # pyNastran leaves a copy of the deck in the working directory when an include is missing
            dump.unlink(missing_ok=True)
        fact = " ".join(str(error).split()) or type(error).__name__
        raise InputError(f"pyNastran cannot read the deck: {fact[:300]}", where=str(path)) from error
    return model


def _refuse_unsupported(model: Any, path: Path) -> None:
    found: Counter[str] = Counter()
    for name, count in model.card_count.items():
        if name not in _MODELLED and name not in _WITHOUT_INFLUENCE:
            found[name] += count
    for grid in model.nodes.values():
        found["GRID with a position frame CP"] += grid.cp != 0
        found["GRID with a displacement frame CD"] += grid.cd != 0
    used = set()
    for element in model.elements.values():
        if element.type == "CHEXA":
            found["CHEXA with 20 nodes"] += len(element.nodes) > 8
        if element.type == "CBAR":
            found["CBAR with pin flags PA/PB"] += bool(element.pa or element.pb)
            found["CBAR with end offsets WA/WB"] += bool(np.any(element.wa) or np.any(element.wb))
            used.add(element.pid)
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


class _Finder:
    """Rows of grid ids; collects the references to grids, properties and materials that do not exist."""

    def __init__(self, grid_id: Ints, path: Path) -> None:
        self._grid_id = grid_id
        self._path = path
        self._missing: list[str] = []

    def rows(self, ids: Any, who: str) -> Ints:
        wanted = np.asarray(ids, dtype=np.int64)
        row = np.searchsorted(self._grid_id, wanted).clip(max=len(self._grid_id) - 1)
        self._missing += [f"{who}: grid {grid}" for grid in np.unique(wanted[self._grid_id[row] != wanted])]
        return np.asarray(row, dtype=np.int64)

    def card(self, table: dict[int, Any], key: int, kind: str, who: str) -> Any:
        """The card `key` of type `kind`, or None after noting that it is missing."""
        found = table.get(key)
        if found is None or found.type != kind:
            self._missing.append(f"{who}: {kind} {key}")
            return None
        return found

    def refuse_missing(self) -> None:
        if self._missing:
            some = "; ".join(self._missing[:10]) + (" ..." if len(self._missing) > 10 else "")
            raise InputError(
                f"{len(self._missing)} reference(s) to cards that do not exist: {some}", where=str(self._path)
            )


def _grids(model: Any) -> tuple[Ints, Floats]:
    grid_id = np.array(sorted(model.nodes), dtype=np.int64)
    return grid_id, np.array([model.nodes[grid].xyz for grid in grid_id], dtype=np.float64).reshape(-1, 3)


def _material(model: Any, finder: _Finder, pid: int, kind: str) -> tuple[Any, Any]:
    """Property and MAT1 of an element, each None where missing."""
    prop = finder.card(model.properties, pid, kind, "elements")
    mat = finder.card(model.materials, prop.mid, "MAT1", f"{kind} {pid}") if prop else None
    return prop, mat


def _hexes(model: Any, finder: _Finder) -> HexBlock:
    ids = sorted(eid for eid, element in model.elements.items() if element.type == "CHEXA")
    pids = np.array([model.elements[eid].pid for eid in ids], dtype=np.int64)
    table = np.ones((5, len(ids)))
    for pid in np.unique(pids):
        _, mat = _material(model, finder, int(pid), "PSOLID")
        if mat is not None:
            if abs(mat.g * 2.0 * (1.0 + mat.nu) / mat.e - 1.0) > 0.01:
                raise InputError(f"MAT1 {mat.mid}: E, G and NU of a solid do not agree within 1 %")
            table[:, pids == pid] = np.array([[mat.e], [mat.nu], [mat.rho], [mat.a], [mat.tref]])
    nodes = finder.rows([model.elements[eid].nodes for eid in ids], "CHEXA").reshape(-1, 8)
    return HexBlock(
        element_id=np.array(ids, dtype=np.int64),
        connectivity=nodes,
        youngs_modulus=table[0],
        poisson_ratio=table[1],
        density=table[2],
        expansion=table[3],
        reference_temperature=table[4],
    )


def _bars(model: Any, finder: _Finder, position: Floats) -> BarBlock:
    ids = sorted(eid for eid, element in model.elements.items() if element.type == "CBAR")
    bars = [model.elements[eid] for eid in ids]
    table = np.ones((9, len(ids)))
    pids = np.array([bar.pid for bar in bars], dtype=np.int64)
    for pid in np.unique(pids):
        prop, mat = _material(model, finder, int(pid), "PBAR")
        if mat is not None:
            section = [prop.A, prop.i1, prop.i2, prop.i12, prop.j]
            table[:, pids == pid] = np.array([*section, mat.e, mat.g, mat.a, mat.tref])[:, None]
    nodes = finder.rows([bar.nodes for bar in bars], "CBAR").reshape(-1, 2)
    orientation = np.zeros((len(bars), 3))
    for k, bar in enumerate(bars):
        if bar.g0:
            orientation[k] = position[finder.rows(bar.g0, f"CBAR {bar.eid} G0")] - position[nodes[k, 0]]
        else:
            orientation[k] = bar.x
    return BarBlock(
        element_id=np.array(ids, dtype=np.int64),
        connectivity=nodes,
        area=table[0],
        inertia_1=table[1],
        inertia_2=table[2],
        inertia_12=table[3],
        torsion_constant=table[4],
        youngs_modulus=table[5],
        shear_modulus=table[6],
        expansion=table[7],
        reference_temperature=table[8],
        orientation=orientation,
    )


def _rigid_elements(model: Any, finder: _Finder) -> tuple[tuple[Rbe2, ...], tuple[Rbe3, ...]]:
    rbe2, rbe3 = [], []
    for eid, element in sorted(model.rigid_elements.items()):
        who = f"{element.type} {eid}"
        if element.type == "RBE2":
            rbe2.append(
                Rbe2(
                    element_id=int(eid),
                    independent=int(finder.rows(element.gn, who)),
                    dependents=finder.rows(element.Gmi, who),
                    components=str(element.cm),
                )
            )
        else:
            counts = [len(grids) for grids in element.Gijs]
            rbe3.append(
                Rbe3(
                    element_id=int(eid),
                    dependent=int(finder.rows(element.refgrid, who)),
                    components=str(element.refc),
                    independents=finder.rows(np.concatenate(element.Gijs), who),
                    weights=np.repeat(np.asarray(element.weights, dtype=np.float64), counts),
                    independent_components=tuple(
                        str(digits) for digits, count in zip(element.comps, counts, strict=True) for _ in range(count)
                    ),
                )
            )
    return tuple(rbe2), tuple(rbe3)


def _constraints(model: Any, constraint: int | None, finder: _Finder) -> tuple[Ints, Ints]:
    """Constrained grid rows and components, from the selected SPC set and the GRID cards, without repetition."""
    pairs: set[tuple[int, int]] = set()
    for grid in model.nodes.values():
        pairs.update((grid.nid, int(digit)) for digit in str(grid.ps or ""))
    for card in [] if constraint is None else _spc_cards(model, constraint):
        nodes = card.nodes
        if card.type == "SPC1":
            components = [card.components] * len(nodes)
            # A THRU range, which pyNastran has expanded, may have gaps; a list of grids may not.
            is_range = len(nodes) > 2 and nodes[-1] - nodes[0] == len(nodes) - 1
            present = [node in model.nodes for node in nodes]
            if is_range and any(present):
                nodes = [node for node, there in zip(nodes, present, strict=True) if there]
                components = components[: len(nodes)]
        else:
            components = card.components
        for node, digits in zip(nodes, components, strict=True):
            pairs.update((int(node), int(digit)) for digit in str(digits) if digit != "0")
    table = np.array(sorted(pairs), dtype=np.int64).reshape(-1, 2)
    return finder.rows(table[:, 0], f"SPC set {constraint}"), table[:, 1]


def _spc_cards(model: Any, constraint: int) -> list[Any]:
    sids = {constraint}
    for one in model.spcadds.get(constraint, []):
        sids.update(one.sets)
    return [card for sid in sorted(sids) for card in model.spcs.get(sid, [])]
