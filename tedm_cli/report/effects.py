"""Effects of the user's own in the report: what each makes of the outputs that it is on."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tedm_cli.noise.areas import AreaTable
from tedm_cli.report.document import Cell, Paragraph, Section, Table, columns, row
from tedm_cli.results.areas import unit_per
from tedm_cli.results.cases.effects import OwnEffect
from tedm_cli.results.ranking import first_largest
from tedm_cli.results.titles import output_title
from tedm_cli.results.wording import capital, sci, unit_text


def effects_section(effects: Sequence[OwnEffect], areas: AreaTable) -> Section:
    """A row for every effect and output."""
    means = ~areas.gradient
    rows = []
    for effect in effects:
        worst = first_largest(range(len(effect.row)), np.abs(effect.row).tolist())
        rows.append(
            row(
                effect.name,
                Cell(capital(output_title(effect.output)), label=effect.output),
                str(areas.name[worst]),
                sci(float(effect.row[worst]), 3),
                unit_per(unit_text(effect.unit), areas.unit[worst]),
                sci(float(np.linalg.norm(effect.row[means])), 3),
            )
        )
    text = (
        "Effects of temperature that no matrix of this report has, by tables of the project's own. They are added to"
        " self-gravity and read-outs with their signs, in all spectra and verdicts, and stand among the contributors by"
        " their names."
    )
    head = columns("Effect", "Output", "Worst area", "Value", "Unit", "Rss over areas", text=(0, 1, 2, 4))
    table = Table(head, tuple(rows), "Effects of the project's own on each output; rss: per kelvin, over all areas.")
    return Section("effects", "Other effects", "Other effects", (Paragraph(text), table))
