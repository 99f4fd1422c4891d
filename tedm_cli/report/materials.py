"""What materials and shells do to the outputs, as a section of the annex."""

from __future__ import annotations

from collections.abc import Sequence

from tedm_cli.report.document import Cell, Paragraph, Row, Section, Table, columns
from tedm_cli.results.adjoint.materials import MaterialEffect
from tedm_cli.results.titles import output_title
from tedm_cli.results.wording import capital, sci


def materials_section(effects: Sequence[MaterialEffect]) -> Section:
    """Every property of a material or of shells, by what a little more of it does, largest first."""
    text = (
        "What one per cent more of a property does to the output that it changes most: the change of the root mean"
        " square of that output where the temperatures of all areas vary independently and by as much. A modulus grows"
        " with the Poisson ratio unchanged; density is that of structural mass. The last column names the area through"
        " which most of it comes."
    )
    head = columns("Property", "Material or shell", "In", "Change\n(%)", "Output", "Most by", text=(0, 1, 2, 4, 5))
    table = Table(head, tuple(map(_row, effects)), "Materials and shells, by what one per cent more of each does.")
    return Section("materials", "Materials", "Materials", (Paragraph(text), table))


def _row(effect: MaterialEffect) -> Row:
    return Row(
        (
            Cell(effect.quantity),
            Cell(effect.of),
            Cell(effect.used_by),
            Cell(sci(effect.change, 3)),
            Cell(capital(output_title(effect.output)), label=effect.output),
            Cell(effect.area),
        )
    )
