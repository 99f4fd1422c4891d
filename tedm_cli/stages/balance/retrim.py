"""balance --retrim: how shims of a balance change when parts and blocks are as they were measured."""

from __future__ import annotations

import difflib
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.balance.boxes import Box, Image, blocks_of, columns_of
from tedm_cli.balance.programme import Programme, balanced, whole_units
from tedm_cli.balance.retrim import least_change
from tedm_cli.config.balance import load_balance
from tedm_cli.config.model.as_built import MeasuredPart, read_measured
from tedm_cli.config.model.compensation import csv_text
from tedm_cli.config.model.file import load_model
from tedm_cli.config.project import Project
from tedm_cli.contracts import BALANCE, SENSITIVITY, UNIT_LOADS
from tedm_cli.errors import InputError
from tedm_cli.files.build_folder import (
    BALANCE_FILE,
    RETRIM_FILE,
    SENSITIVITY_FILE,
    UNIT_LOADS_FILE,
    provenance,
    require_configuration,
    require_input,
)
from tedm_cli.files.store import Writer, create, open_checked, replacing
from tedm_cli.gravity.compensation import CompensationMass
from tedm_cli.gravity.requirements import DcVerdict
from tedm_cli.progress import Step
from tedm_cli.results.gravity.balance import BalanceResults, read_balance
from tedm_cli.stages.balance.candidates import ALIKE, MIRROR, Candidates, candidates, with_ties
from tedm_cli.stages.balance.parts import Parts
from tedm_cli.stages.balance.rest import read_rest
from tedm_cli.stages.balance.solve import could_be_met, programme_of, tied, verdicts_of
from tedm_cli.stages.balance.write import write_blocks, write_candidates, write_requirements, write_totals
from tedm_cli.stages.common import out_path

RETRIMMED_CSV = "retrim_masses.csv"


@dataclass(frozen=True, eq=False)
class RetrimSummary:
    """The files, what the first says, how many parts were measured, and the time."""

    path: Path
    csv: Path
    results: BalanceResults
    measured: int
    seconds: float


def retrim(project: Project, table: Path, output: Path | None, csv: Path | None, step: Step) -> RetrimSummary:
    """Write retrim.h5 and the CSV of the blocks as they are then.

    Every block may change by itself, also images, as what was built is like no image.

    Raises
    ------
    ConfigError, PhysicsError : as `balance` does.
    InputError : files that are missing or stale; a table of parts that is wrong, or names blocks that are not there.
    """
    begin = time.perf_counter()
    path = project.required_balance()
    model_file, model = load_model(project.model)
    model.required_test_masses(project.model)
    file, config = load_balance(path, model.test_masses(), {rule.group for rule in model.areas.rule})
    build = project.build_dir
    sources = [build / name for name in (SENSITIVITY_FILE, UNIT_LOADS_FILE, BALANCE_FILE)]
    measured = read_measured(table)
    trace = provenance([model_file, file], [*sources, table])
    out, blocks_file = out_path(project, RETRIM_FILE, output), csv or build / RETRIMMED_CSV
    with (
        open_checked(sources[0], SENSITIVITY) as sensitivity,
        open_checked(sources[1], UNIT_LOADS) as unit,
        open_checked(sources[2], BALANCE) as balance_file,
    ):
        require_input(sensitivity, trace.inputs[1])
        require_input(balance_file, trace.inputs[0])
        require_configuration(balance_file, path)
        old = read_balance(balance_file)
        rest = read_rest(project, model, sensitivity, config.subsystems, keep=config.existing == "keep", where=path)
        found = _single(_where_they_are(candidates(project, model, config, unit, rest.kept, path), old))
        of_blocks = _measured_blocks(measured, old)
        change = _change_of_parts(Parts(unit, rest), [m for m in measured if m.part.kind != "block"], step)
        programme, _ = programme_of(rest, _at_their_places(found, of_blocks), config, step)
        programme = replace(programme, rest=programme.rest + change)
        before = _units_before(found, old)
        extended = least_change(programme, before)
        relaxed, conflicts = balanced(extended)
        solution, beyond = whole_units(extended, relaxed, config.time_limit_s)
        count = len(before)
        units = solution.units[:count]
        blocks = blocks_of(found.parts, found.columns, units)
        blocks = with_ties(blocks, tied(config, found), unit)
    there = blocks_of(found.parts, found.columns, before)
    was, now = (_with(change, verdicts_of(rest, as_built(b, of_blocks))) for b in (there, blocks))
    built = as_built(blocks, of_blocks)
    relaxed, solution = (replace(s, units=s.units[:count], room_kg=s.room_kg[:count]) for s in (relaxed, solution))
    with create(out, BALANCE, trace) as writer:
        write_requirements(writer, was, now, programme, solution, conflicts)
        writer.write(BALANCE.OFF, np.zeros(len(was)), units="see /requirement/unit")
        write_candidates(writer, config, found, programme, relaxed, solution, conflicts)
        write_blocks(writer, found, built)
        could = could_be_met(programme, conflicts, config)
        write_totals(writer, config, programme, relaxed, solution, beyond, could)
        _write_before(writer, found, programme, before)
    with replacing(blocks_file) as temporary:
        temporary.write_text(csv_text([*rest.csv, *built]), encoding="utf-8", newline="")
    with open_checked(out, BALANCE) as written:
        results = read_balance(written)
    return RetrimSummary(out, blocks_file, results, len(measured), time.perf_counter() - begin)


@dataclass(frozen=True)
class MeasuredBlock:
    """Mass of a block over what it was meant to be, and how far it is from its place (m, basic frame)."""

    ratio: float
    offset_m: tuple[float, float, float]

    def of(self, block: CompensationMass) -> CompensationMass:
        """The block as it is."""
        centre = block.centre_m + np.array(self.offset_m)
        return replace(block, centre_m=centre, mass_kg=self.ratio * block.mass_kg)


def as_built(blocks: Sequence[CompensationMass], measured: Mapping[str, MeasuredBlock]) -> list[CompensationMass]:
    """Blocks as they were measured; others as they are meant to be."""
    return [measured[b.name].of(b) if b.name in measured else b for b in blocks]


def _where_they_are(found: Candidates, old: BalanceResults) -> Candidates:
    """Blocks whose places and sizes were sought, as the balance has found them; others of them are gone."""
    parts, box = [], []
    for part, number in zip(found.parts, found.box, strict=True):
        there = part
        if part.inner_m is not None:
            if part.name not in old.block:
                continue
            row = old.block.index(part.name)
            there = replace(part, centre_m=old.centre[row], size_m=old.size[row], inner_m=None, vary_size=False)
        parts.append(there)
        box.append(number)
    return Candidates(parts, box, columns_of(parts), found.left_out)


def _single(found: Candidates) -> Candidates:
    """Every image as a candidate of its own."""
    pairs = [(replace(p, images=(i,)), n) for p, n in zip(found.parts, found.box, strict=True) for i in p.images]
    parts = [replace(part, name=part.name + part.images[0].suffix, images=(_unnamed(part),)) for part, _ in pairs]
    return Candidates(parts, [n for _, n in pairs], columns_of(parts), found.left_out)


def _unnamed(part: Box) -> Image:
    return replace(part.images[0], suffix="")


def _measured_blocks(measured: Sequence[MeasuredPart], old: BalanceResults) -> dict[str, MeasuredBlock]:
    """Measured blocks by name; `InputError` for a block that the balance does not have."""
    found = {}
    for m in measured:
        if m.part.kind != "block":
            continue
        if m.part.name not in old.block:
            near = difflib.get_close_matches(m.part.name, old.block, n=1)
            hint = f"did you mean {near[0]}?" if near else f"there are: {', '.join(old.block[:8])}"
            raise InputError(f"the balance has no block {m.part.name!r}", where=m.part.where, hint=hint)
        meant = float(old.block_kg[old.block.index(m.part.name)])
        found[m.part.name] = MeasuredBlock(m.mass_kg / meant if m.mass_kg else 1.0, m.offset_m)
    return found


def _at_their_places(found: Candidates, measured: Mapping[str, MeasuredBlock]) -> Candidates:
    """Unknowns whose blocks are as they were measured: all shims of a block are as heavy, and off, as it is."""
    columns = [replace(column, blocks=tuple(as_built(column.blocks, measured))) for column in found.columns]
    return replace(found, columns=columns)


def _change_of_parts(parts: Parts, measured: Sequence[MeasuredPart], step: Step) -> FloatArray:
    """What the limited quantities [r] change by parts of the model as they were measured."""
    total = np.zeros(len(parts.rest.before))
    for m, field in zip(measured, parts.fields([m.part for m in measured], step), strict=True):
        ratio = m.mass_kg / field.mass_kg - 1.0 if m.mass_kg else 0.0
        total += field.change(np.array([ratio]), np.array([m.offset_m]))[0]
    return total


def _units_before(found: Candidates, old: BalanceResults) -> FloatArray:
    """Numbers of units [c] that the balance has; `InputError` where it is of other boxes."""
    each = dict(zip(old.candidate, old.mass_kg / old.images, strict=True))
    units = np.zeros(len(found.columns))
    for row, part in enumerate(found.parts):
        own = [i for i, column in enumerate(found.columns) if column.box == row]
        mass = next((m for name, m in each.items() if part.name in (name, *_image_names(name))), 0.0)
        done = mass / found.columns[own[0]].unit_kg
        units[own] = np.clip(done - np.arange(len(own)), 0.0, 1.0) if part.shim_m else done
    return np.where([c.whole for c in found.columns], np.round(units), units)


def _image_names(name: str) -> tuple[str, ...]:
    return (name + MIRROR, name + ALIKE, name + ALIKE + MIRROR)


def _with(change: FloatArray, verdicts: Sequence[DcVerdict]) -> list[DcVerdict]:
    return [replace(v, value=v.value + float(c)) for v, c in zip(verdicts, change, strict=True)]


def _write_before(writer: Writer, found: Candidates, programme: Programme, before: FloatArray) -> None:
    parts = [[i for i, c in enumerate(found.columns) if c.box == row] for row in range(len(found.parts))]
    steps = [found.columns[own[0]].whole for own in parts]
    shims = np.where(steps, [round(float(before[own].sum())) for own in parts], -1)
    writer.write(BALANCE.MASS_BEFORE, np.array([programme.unit_kg[own] @ before[own] for own in parts]))
    writer.write(BALANCE.SHIMS_BEFORE, shims.astype(np.int64))
