"""What thermal areas, groups of them and optical elements do to every output."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from tedm_cli.arrays import BoolArray, FloatArray
from tedm_cli.noise.areas import AreaTable
from tedm_cli.optics.shares import shares
from tedm_cli.results.areas import unit_per
from tedm_cli.results.explained import Cell, Column, Table, Told, by_share, by_size, clean_sum, row_tables, sizes
from tedm_cli.results.optics import ReadOuts
from tedm_cli.results.titles import output_title
from tedm_cli.results.within import Gradients
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
    """What the motion of an optical element carries of every read-out."""
    i = r.element.index(name)
    listed = []
    for chosen in r.sets:
        terms = r.by_element(chosen)[:, i][:, means]
        for row, (label, term) in enumerate(zip(r.label, terms, strict=True)):
            share = float(shares(term[None], r.N[chosen][row][means])[0])
            listed.append((f"{chosen}_{label}", float(np.linalg.norm(term)), f"{r.unit[row]}/K", share))
    columns = (Column("output"), Column("size", "number"), Column("unit"), Column("share", "share"))
    bench = next((b for b, elements in r.benches.items() if name in elements), "")
    where = (f"on bench {bench}",) if len(r.benches) > 1 and bench else ()
    note = f"size: root of the sum of squares over the areas, of what its motion does; {_SHARE}, signed"
    table = Table("read_outs", columns, by_share(listed, 3), ranked=True)
    nothing = () if table.rows else ("its motion is in no read-out",)
    return Told(name, "optical element", name, (*where, *nothing), (table,), (note,) if table.rows else ())


def explain_difference(
    label: str,
    terms: Sequence[tuple[float, str]],
    rows: Rows,
    elements: Sequence[str],
    parts: Mapping[str, FloatArray],
    areas: AreaTable,
) -> Told:
    """What the difference of two read-outs is made of; `parts`: by read-out, its terms [E, k] by optical element."""
    unit = rows[terms[0][1]][0]
    value = np.asarray(sum(f * rows[name][1] for f, name in terms))
    means = ~areas.gradient
    size, total = sizes(value, means)
    by_element = np.asarray(sum(f * parts[name] for f, name in terms))[:, means]
    listed = [
        (name, float(np.linalg.norm(term)), float(share))
        for name, term, share in zip(elements, by_element, shares(by_element, value[means]), strict=True)
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
