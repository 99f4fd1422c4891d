"""What thermal areas, groups of them and optical elements do to every output."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from tedm_cli.arrays import BoolArray, FloatArray
from tedm_cli.noise.areas import AreaTable
from tedm_cli.noise.effects import Effects
from tedm_cli.optics.shares import shares
from tedm_cli.results.adjoint.within import Gradients
from tedm_cli.results.areas import unit_per
from tedm_cli.results.explained import Cell, Column, Table, Told, by_share, by_size, clean_sum, row_tables, sizes
from tedm_cli.results.optics import ReadOuts
from tedm_cli.results.titles import output_title
from tedm_cli.results.wording import count

_SHARE = "share: of the output's variance where all areas of a mean temperature fluctuate alike and independently"
Rows = dict[str, tuple[str, FloatArray]]
"""By label of an output, its unit before "/K", and its row [k] per kelvin of each area."""


def explain_area(name: str, areas: AreaTable, rows: Rows) -> Told:
    """What one area does to every output."""
    i = areas.name.tolist().index(name)
    mean = not areas.gradient[i]
    listed: list[tuple[Cell, ...]] = []
    for label, (unit, row) in rows.items():
        if mean:
            rank = 1 + int((np.abs(row[~areas.gradient]) > abs(row[i])).sum())
            share = row[i] ** 2 / power if (power := float(row[~areas.gradient] @ row[~areas.gradient])) else 0.0
            listed.append((label, float(row[i]), unit_per(unit, areas.unit[i]), float(share), float(rank)))
        else:
            listed.append((label, float(row[i]), unit_per(unit, areas.unit[i])))
    head = (Column("output"), Column("value", "number"), Column("unit"))
    columns = (*head, Column("share", "share"), Column("rank", "number")) if mean else head
    table = Table("outputs", columns, by_size(listed, 3) if mean else tuple(listed), ranked=mean)
    kind = "a gradient, 1 K/m" if not mean else "a mean temperature, 1 K"
    number = int((~areas.gradient).sum())
    facts = (f"group {areas.group[i]}; {areas.shield[i]} the thermal shield; side {areas.side[i]}; load: {kind}",)
    notes = (f"{_SHARE}; rank: among {count(number, 'area')}",) if mean else ()
    return Told(name, "thermal area", name, facts, (table,), notes)


def explain_gradient(name: str, of: Gradients, cases: Sequence[str], units: Mapping[str, str]) -> Told:
    """What a gradient within areas does to every output; `units` of the outputs, by label."""
    i = of.areas.name.tolist().index(name)
    extent = float(of.extent_m[i])
    listed: list[tuple[Cell, ...]] = [
        (label, float(row[i]), unit_per(units[label], "K/m"), float(row[i]) / extent, unit_per(units[label], "K"))
        for label, row in of.rows.items()
    ]
    columns = (
        *(Column("output"), Column("value", "number"), Column("unit"), Column("across", "number"), Column("unit")),
    )
    areas = of.areas
    axis = areas.kind[i].removeprefix("gradient_")
    facts = (
        f"group {areas.group[i]}; {areas.shield[i]} the thermal shield; side {areas.side[i]}; no unit load: from"
        f" adjoint.h5; in case{'s' if len(cases) > 1 else ''} {', '.join(cases)}",
        f"1 K/m along {axis} of the basic frame, {1e3 * extent:.4g} mm from end to end; {of.spectra[i].level_K:.3g}"
        f" K/m/sqrt(Hz), {of.spectra[i].words()}",
    )
    note = "across: per kelvin of difference between the ends"
    return Told(name, "gradient within areas", name, facts, (Table("outputs", columns, tuple(listed)),), (note,))


def explain_group(name: str, areas: AreaTable, rows: Rows) -> Told:
    """What the areas of a group do, all together by a kelvin, to every output."""
    own = (areas.group == name) & ~areas.gradient
    listed = []
    for label, (unit, row) in rows.items():
        power = float(row[~areas.gradient] @ row[~areas.gradient])
        share = float(row[own] @ row[own]) / power if power else 0.0
        listed.append((label, clean_sum(row[own]), unit_per(unit, "K"), share))
    columns = (Column("output"), Column("sum", "number"), Column("unit"), Column("share", "share"))
    members = areas.name[areas.group == name].tolist()
    return Told(
        name,
        "group of thermal areas",
        name,
        (f"{count(len(members), 'area')}: {', '.join(members)}",),
        (Table("outputs", columns, by_size(listed, 3), ranked=True),),
        (f"sum: all areas of the group by 1 K; {_SHARE}",),
    )


def explain_element(name: str, r: ReadOuts, means: BoolArray) -> Told:
    """What the motion of an optical element carries of every read-out, and its glass where that changes."""
    i = r.element.index(name)
    parts = {"motion": {chosen: r.by_element(chosen)[:, i] for chosen in r.sets}}
    if r.plates is not None and name in r.plates.name:
        plate = r.plates.name.index(name)
        parts["glass"] = {chosen: r.by_plate(chosen)[:, plate].sum(axis=1) for chosen in r.sets}
    listed: list[tuple[Cell, ...]] = []
    for part, by_set in parts.items():
        by = (part,) if len(parts) > 1 else ()
        for chosen, terms in by_set.items():
            for row, (label, term) in enumerate(zip(r.label, terms[:, means], strict=True)):
                share = float(shares(term[None], r.N[chosen][row][means])[0])
                listed.append((f"{chosen}_{label}", *by, float(np.linalg.norm(term)), f"{r.unit[row]}/K", share))
    by_column = (Column("part"),) if len(parts) > 1 else ()
    columns = (Column("output"), *by_column, Column("size", "number"), Column("unit"), Column("share", "share"))
    bench = next((b for b, elements in r.benches.items() if name in elements), "")
    where = (f"on bench {bench}",) if len(r.benches) > 1 and bench else ()
    what = "what its motion does" + ", or its glass by index and thickness" * (len(parts) > 1)
    note = f"size: root of the sum of squares over the areas, of {what}; {_SHARE}, signed"
    table = Table("read_outs", columns, by_share(listed, len(columns) - 1), ranked=True)
    nothing = () if table.rows else ("its motion is in no read-out",)
    return Told(name, "optical element", name, (*where, *nothing), (table,), (note,) if table.rows else ())


def explain_effect(name: str, effects: Effects, rows: Rows, areas: AreaTable) -> Told:
    """What an effect of the user's own is of every output that it is on."""
    own = effects.rows[effects.names.index(name)]
    means = ~areas.gradient
    listed: list[tuple[Cell, ...]] = []
    for row, (label, (unit, whole)) in zip(own, rows.items(), strict=True):
        if row.any():
            worst = int(np.abs(row).argmax())
            share = float(shares(row[None, means], whole[means])[0])
            per = unit_per(unit, areas.unit[worst])
            listed.append(
                (
                    label,
                    float(np.linalg.norm(row[means])),
                    f"{unit}/K",
                    share,
                    areas.name[worst],
                    float(row[worst]),
                    per,
                )
            )
    columns = (Column("output"), Column("size", "number"), Column("unit"), Column("share", "share"),
               Column("most by"), Column("value", "number"), Column("per"))  # fmt: skip
    note = f"size: root of the sum of squares over the areas of a mean temperature; {_SHARE}, signed"
    table = Table("outputs", columns, by_share(listed, 3), ranked=True)
    return Told(name, "effect of your own", name, (), (table,), (note,))


def explain_difference(
    label: str,
    terms: Sequence[tuple[float, str]],
    rows: Rows,
    parts: Mapping[str, FloatArray],
    areas: AreaTable,
) -> Told:
    """What the difference of two read-outs is made of; `parts`: its terms [k] by optical element that moves, by plate
    whose glass changes, and by effect of the user's own."""
    unit = rows[terms[0][1]][0]
    value = np.asarray(sum(f * rows[name][1] for f, name in terms))
    means = ~areas.gradient
    size, total = sizes(value, means)
    by_part = np.array(list(parts.values()))[:, means]
    listed = [
        (name, float(np.linalg.norm(term)), float(share))
        for name, term, share in zip(parts, by_part, shares(by_part, value[means]), strict=True)
    ]
    columns = (Column("element"), Column("size", "number", unit_per(unit, "K")), Column("share", "share"))
    return Told(
        label,
        "difference of read-outs",
        output_title(label),
        (f"size {size:.3e} {unit_per(unit, 'K')} over {int(means.sum())} areas; sum, the uniform load,"
         f" {total:.3e} {unit_per(unit, 'K')}",),
        (*row_tables(value, unit, areas), Table("elements", columns, by_share(listed, 2), ranked=True)),
        ("size: root of the sum of squares over the areas; share: of the variance for areas that fluctuate alike and"
         " independently, signed",),
    )  # fmt: skip
