"""The figure of a balance: blocks in sections of the model, and limits before and after."""

from __future__ import annotations

from itertools import product
from pathlib import Path

import numpy as np

from tedm_cli.config.project import Project
from tedm_cli.files.store import Reader
from tedm_cli.results.gravity.balance import BalanceResults
from tedm_cli.results.wording import count
from tedm_cli.stages.area_drawing import write_figure
from tedm_cli.stages.balance.candidates import structure_of
from tedm_cli.stages.balance.rest import Rest


def draw_balance(path: Path, project: Project, source: Path, r: BalanceResults, rest: Rest, unit: Reader) -> None:
    """Draw what the file `source` says into `path`."""
    from tedm_cli.figures.balance import Surroundings, balance_figure

    elements = structure_of(unit)
    signs = np.array(list(product((-0.5, 0.5), repeat=3)))
    around = Surroundings(
        low=elements.low_m,
        high=elements.high_m,
        test_mass=[tm.name for tm in rest.test_masses],
        corner=np.array([tm.box_centre_m + (signs * tm.side_m) @ tm.axes for tm in rest.test_masses]),
    )
    blocks = count(len(r.block), "block")
    title = f"{project.title}: {r.met} of {len(r.after)} limits at rest met with {r.total_kg:.3g} kg in {blocks}"
    write_figure(path, balance_figure(r, around, title), title, source)
