"""balance: masses in the boxes of the configuration that bring the field at rest within its limits."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path

from tedm_cli.balance.boxes import blocks_of
from tedm_cli.config.balance import load_balance
from tedm_cli.config.model.compensation import csv_text
from tedm_cli.config.model.file import load_model
from tedm_cli.config.project import Project
from tedm_cli.contracts import BALANCE, DISTORTION, SENSITIVITY, UNIT_LOADS
from tedm_cli.files.build_folder import (
    BALANCE_FILE,
    DISTORTION_FILE,
    SENSITIVITY_FILE,
    UNIT_LOADS_FILE,
    provenance,
    require_input,
)
from tedm_cli.files.store import create, open_checked, replacing
from tedm_cli.progress import Step
from tedm_cli.results.gravity.balance import BalanceResults, read_balance
from tedm_cli.stages.area_drawing import require_format
from tedm_cli.stages.balance.candidates import candidates, with_ties
from tedm_cli.stages.balance.draw import draw_balance
from tedm_cli.stages.balance.places import Sought, with_places
from tedm_cli.stages.balance.price import thermal_price, write_price
from tedm_cli.stages.balance.rest import read_rest
from tedm_cli.stages.balance.solve import could_be_met, programme_of, solved, tied, verdicts_of
from tedm_cli.stages.balance.tolerances import deviations, drawn, read_all
from tedm_cli.stages.balance.write import (
    off_of,
    write_blocks,
    write_candidates,
    write_requirements,
    write_tolerances,
    write_totals,
)
from tedm_cli.stages.common import out_path

CSV_FILE = "balance_masses.csv"


@dataclass(frozen=True, eq=False)
class BalanceSummary:
    """The files, what the first says, parts of boxes that were left out, compensation masses that stay, and the time.

    csv : the compensation masses of a balanced model. kept : how many of them are not of the balance. turning : tied
    blocks that are not in the thermal price. sought : what there was to seek of places and sizes.
    """

    path: Path
    csv: Path
    results: BalanceResults
    left_out: dict[str, int]
    kept: int
    replaced: bool
    turning: list[str]
    sought: Sought | None
    seconds: float


def balance(
    project: Project, output: Path | None, csv: Path | None, step: Step, figure: Path | None = None
) -> BalanceSummary:
    """Write balance.h5, the CSV of compensation masses, and the figure where one is wanted.

    Raises
    ------
    ConfigError : the project says nothing of boxes, or something wrong; nothing is limited.
    InputError : sensitivity.h5 or unit_loads.h5 is missing or stale.
    PhysicsError : no whole shims were found.
    """
    begin = time.perf_counter()
    require_format(figure)
    path = project.required_balance()
    model_file, model = load_model(project.model)
    model.required_test_masses(project.model)
    file, config = load_balance(path, model.test_masses(), {rule.group for rule in model.areas.rule})
    sources = [project.build_dir / name for name in (SENSITIVITY_FILE, UNIT_LOADS_FILE, DISTORTION_FILE)]
    out, table = out_path(project, BALANCE_FILE, output), csv or project.build_dir / CSV_FILE
    parts = None if config.tolerance is None or config.tolerance.parts is None else path.parent / config.tolerance.parts
    trace = provenance([model_file, file], [*sources, *([] if parts is None else [parts])])
    with open_checked(sources[0], SENSITIVITY) as sensitivity, open_checked(sources[1], UNIT_LOADS) as unit:
        require_input(sensitivity, trace.inputs[1])
        require_input(sensitivity, trace.inputs[2])
        rest = read_rest(project, model, sensitivity, config.subsystems, keep=config.existing == "keep", where=path)
        found = candidates(project, model, config, unit, rest.kept, path)
        found, sought = with_places(rest, found, config, step)
        programme, effects = programme_of(rest, found, config, step)
        tolerances = read_all(parts, config, unit, rest, step)
        off = None if tolerances is None else deviations(tolerances, rest, found, effects, step)
        relaxed, conflicts, solution, beyond = solved(programme, off, config)
        blocks = blocks_of(found.parts, found.columns, solution.units)
        blocks = with_ties(blocks, tied(config, found), unit)
        with open_checked(sources[2], DISTORTION) as distortion:
            price = thermal_price(rest, blocks, sensitivity, distortion, unit)
    before, after = rest.before, verdicts_of(rest, blocks)
    with create(out, BALANCE, trace) as writer:
        write_requirements(writer, before, after, programme, solution, conflicts)
        writer.write(BALANCE.OFF, off_of(off, solution, len(before)), units="see /requirement/unit")
        write_candidates(writer, config, found, programme, relaxed, solution, conflicts)
        write_blocks(writer, found, blocks)
        could = could_be_met(programme, conflicts, config)
        write_totals(writer, config, programme, relaxed, solution, beyond, could)
        if price is not None:
            write_price(writer, price)
        if off is not None and tolerances is not None:
            write_tolerances(writer, off, solution, drawn(tolerances, rest, blocks, step))
    with replacing(table) as temporary:
        temporary.write_text(csv_text([*rest.csv, *blocks]), encoding="utf-8", newline="")
    with open_checked(out, BALANCE) as written:
        results = read_balance(written)
    if figure is not None:
        with open_checked(sources[1], UNIT_LOADS) as unit:
            draw_balance(figure, project, out, results, rest, unit)
    replaced = config.existing == "replace" and bool(model.compensation_mass or model.gravity.compensation_masses)
    turning = [] if price is None else price.left_out
    seconds = time.perf_counter() - begin
    return BalanceSummary(out, table, results, found.left_out, len(rest.kept), replaced, turning, sought, seconds)
