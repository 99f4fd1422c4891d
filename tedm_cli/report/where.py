"""Where a kelvin hurts: the places of the model on which the output that binds depends most."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from tedm_cli.arrays import FloatArray
from tedm_cli.report.document import Block, Figure, Paragraph, Section, Table, columns, row
from tedm_cli.report.verdicts import noise_judgements, worst_first
from tedm_cli.results.adjoint.map import MappedModel, OutputMap
from tedm_cli.results.cases.noise import CaseNoise
from tedm_cli.results.titles import output_title
from tedm_cli.results.wording import and_text, count, decimals, percent, sci, unit_text

_SHOWN = 10


@dataclass(frozen=True, eq=False)
class Where:
    """The map of the output that binds, and the mesh it is of; or, in `no_map`, why there is none.

    length_m, ratio : [L], of even temperature fields of these correlation lengths, how much of the output's root mean
    square the areas tell; None where that was not found.
    """

    output: OutputMap | None = None
    model: MappedModel | None = None
    no_map: str = ""
    length_m: FloatArray | None = None
    ratio: FloatArray | None = None


def binding_output(cases: Sequence[CaseNoise]) -> str:
    """Label of the judged output that a reader must know first, of several that say the same the first; empty where
    nothing is judged."""
    found = worst_first(noise_judgements(cases))
    return found[0].output.split(", ")[0] if found else ""


def _against_a_field(where: Where, names: str) -> list[Block]:
    """Whether areas of one temperature are enough for this output."""
    if where.length_m is None or where.ratio is None:
        return []
    told = [f"{percent(r)} at {1e3 * length:g} mm" for length, r in zip(where.length_m, where.ratio, strict=True)]
    text = (
        "Areas of one temperature each tell a part of what an uneven temperature does to the"
        f" {output_title(names)}: of its root mean square in a field of one amplitude everywhere, {and_text(told)} of"
        " correlation length. 100 % would be all of it; the rest is done by temperatures that differ within areas."
    )
    return [Paragraph(text)]


def where_section(cases: Sequence[CaseNoise], where: Where, figures: Sequence[Figure]) -> Section:
    """The figure of the output that binds, and a table of its places; or why there is neither."""
    title = "Evidence: where a kelvin acts"
    if where.output is None or where.model is None:
        words = f"Where in the areas temperatures act has not been found: {where.no_map}."
        return Section("where", title, "Where", (Paragraph(words),))
    names = worst_first(noise_judgements(cases))[0].output
    places = where.model.places(where.output)
    unit = unit_text(where.output.unit)
    rows = tuple(
        row(
            where.model.area_name(p.area),
            percent(p.share, 1),
            sci(p.value, 3),
            decimals(p.position.tolist(), 1e3, 0),
            sci(1e6 * p.volume, 3),
            f"{len(p.elements):,}",
        )
        for p in places[:_SHOWN]
    )
    head = columns("Area", "Share", f"Sensitivity\n({unit})", "Centre\n(mm)", "Volume\n(cm³)", "Elements", text=(0,))
    caption = (
        f"Places with the largest shares in the {output_title(names)}; centres in the Nastran basic frame."
        f" {percent(sum(p.share for p in places[:_SHOWN]))} of all sizes are in them, the rest in"
        f" {count(max(len(places) - _SHOWN, 0), 'other')}."
    )
    blocks: list[Block] = [
        Paragraph(
            f"Shown for the {output_title(names)}, which is nearest to its limit or furthest beyond it. A place is"
            " connected elements of one thermal area on which a kelvin acts in one direction; its share is of the sizes"
            " of all elements' sensitivities, whatever their signs. Two places of one area with opposite signs cancel"
            " as long as the area warms evenly: a gradient between them does not."
        ),
        *_against_a_field(where, names),
        *figures,
        Table(head, rows, caption, tight=True),
    ]
    return Section("where", title, "Where", tuple(blocks))
