"""What a requirement judges, and what an output of the drag-free loop or a source of its noise is made of."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from tedm_cli.config.cases import load_cases
from tedm_cli.config.dynamics.loop import load_dynamics
from tedm_cli.config.model.file import load_model
from tedm_cli.config.project import Project
from tedm_cli.contracts import CASE, DYNAMICS, SENSITIVITY, SIMULATION
from tedm_cli.contracts.spec import FileKind
from tedm_cli.dynamics.judging import THERMAL
from tedm_cli.dynamics.signals import OUTPUTS, unit
from tedm_cli.errors import InputError
from tedm_cli.files.build_folder import (
    DYNAMICS_FILE,
    SENSITIVITY_FILE,
    case_file_name,
    require_configuration,
    simulation_file_name,
)
from tedm_cli.files.store import Reader, open_checked
from tedm_cli.gravity.requirements import ALL, AtRestLimit, DcVerdict
from tedm_cli.noise.requirements import AppliedRequirement
from tedm_cli.results.areas import read_areas
from tedm_cli.results.cases.uncertainty import read_uncertainty
from tedm_cli.results.dynamics.loop import LoopOutput, read_simulation
from tedm_cli.results.explained import Cell, Column, Table, Told, by_share, by_size
from tedm_cli.results.gravity.field import dc_verdicts
from tedm_cli.results.thermal.case_shares import of_network
from tedm_cli.results.titles import at_rest_requirement, output_title, outputs_title
from tedm_cli.results.wording import and_text, count, ratio_text
from tedm_cli.uncertainty.verdicts import Distribution

_NOISE = (
    *(Column("output"), Column("requirement"), Column("case"), Column("role"), Column("ratio", "ratio")),
    *(Column("at Hz", "number"), Column("verdict", "verdict")),
)


_CHANCES = (
    *(Column("output"), Column("requirement"), Column("case"), Column("violated", "chance")),
    *(Column("by factor 1", "chance"), Column("5 %", "ratio"), Column("median", "ratio"), Column("95 %", "ratio")),
)


def requirement_names(project: Project) -> list[str]:
    """Names of all requirements: on noise, on the drag-free loop, on the field at rest."""
    noise = [r.requirement.name for r in load_cases(project.cases)[1].applied_requirements()]
    loop = [r.requirement.name for r in _of_loop(project)]
    return list(dict.fromkeys([*noise, *loop, *(limit.requirement for limit in _at_rest(project))]))


def _of_loop(project: Project) -> list[AppliedRequirement]:
    return load_dynamics(project.dynamics)[1].applied_requirements()


def _at_rest(project: Project) -> list[AtRestLimit]:
    return load_model(project.model)[1].limits_at_rest()


def explain_requirement(project: Project, name: str) -> Told:
    """What a requirement judges, and the verdicts by it in the files that are there."""
    noise = [r for r in load_cases(project.cases)[1].applied_requirements() if r.requirement.name == name]
    loop = [r for r in _of_loop(project) if r.requirement.name == name]
    limits = [limit for limit in _at_rest(project) if limit.requirement == name]
    facts, tables, notes = [], [], []
    for applied, where in [*((r, "") for r in noise), *((r, " of the drag-free loop") for r in loop)]:
        q = applied.requirement
        low, high = q.amplitude(np.array(q.band_hz)).tolist()
        facts += [
            f"judges {', '.join(applied.outputs)}{where}: {outputs_title(applied.outputs)}",
            f"limit {low:.3g} {q.unit}/sqrt(Hz) at {1e3 * q.band_hz[0]:.3g} mHz, {high:.3g} at"
            f" {1e3 * q.band_hz[1]:.3g} mHz; {q.source}",
        ]
    kinds = ((CASE, "cases", noise, case_file_name), (SIMULATION, "loop", loop, simulation_file_name))
    for kind, key, given, of in kinds:
        if given:
            rows, unread = _verdicts(project, kind, of, lambda _, requirement: requirement == name)
            tables.append(Table(key, _NOISE, rows, ranked=True))
            notes += unread
            facts += _summary(rows)
    tables.append(_chances(project, lambda _, requirement: requirement == name))
    if limits:
        sources = and_text(list(dict.fromkeys(limit.source for limit in limits)))
        facts.append(f"limits the field at rest by {count(len(limits), 'limit')}: {sources}")
        tables.append(_at_rest_table(project, name))
    title = next((r.requirement.title for r in (*noise, *loop) if r.requirement.title), at_rest_requirement(name))
    if noise or loop:
        notes.append("ratio: safety factor x noise / limit, where it is largest")
    return Told(name, "requirement", title, tuple(facts), tuple(tables), tuple(notes))


def _summary(rows: tuple[tuple[Cell, ...], ...]) -> list[str]:
    """How many of the verdicts `_NOISE` are passed, and the worst of them."""
    if not rows:
        return []
    output, _, case_id, _, ratio, *_ = rows[0]
    passed = sum(bool(row[-1]) for row in rows)
    assert isinstance(ratio, float)
    return [
        f"{passed} of {count(len(rows), 'verdict')} pass; worst: {output} in case {case_id}, ratio {ratio_text(ratio)}"
    ]


def explain_case(project: Project, name: str) -> Told:
    """What a case is, and its verdicts by itself and in closed loop."""
    config = load_cases(project.cases)[1]
    table = config.case_table(name, where=str(project.cases))
    notes: list[str] = []
    tables = []
    facts: list[str] = []
    for kind, key, of in ((CASE, "verdicts", case_file_name), (SIMULATION, "closed_loop", simulation_file_name)):
        if (project.build_dir / of(name)).exists() or kind is CASE:
            rows, unread = _verdicts(project, kind, of, lambda *_: True, [name])
            tables.append(Table(key, _NOISE, rows, ranked=True))
            notes += unread
            facts += [f"{'by itself' if kind is CASE else 'in closed loop'}: {line}" for line in _summary(rows)]
    path = project.build_dir / case_file_name(name)
    if path.exists():
        with open_checked(path, CASE) as file:
            areas = read_areas(file)
            if of_network(file):
                names = ", ".join(file.strings(CASE.DISTURBANCE_NAME))
                facts.append(f"temperatures of the thermal network, by its nodes on the model; disturbances: {names}")
        if areas.within.any():
            facts.append(f"with gradients within areas: {', '.join(areas.name[areas.within].tolist())}")
    tables.append(_chances(project, lambda *_: True, [name]))
    notes.append(f"`tedm run-case {name} -v` says what each verdict comes from")
    return Told(name, "case", table.title, tuple(facts), tuple(tables), tuple(notes))


def loop_noise_names(project: Project) -> list[str]:
    """Noise sources of the drag-free loop and their groups; none where the loop has not been made."""
    path = project.build_dir / DYNAMICS_FILE
    if not path.exists():
        return []
    with open_checked(path, DYNAMICS) as file:
        return [*file.strings(DYNAMICS.NOISE_NAME), *dict.fromkeys(file.strings(DYNAMICS.NOISE_GROUP)), THERMAL]


def loop_output_names(project: Project) -> list[str]:
    """Outputs of the drag-free loop; none where it has not been made."""
    return list(OUTPUTS) if (project.build_dir / DYNAMICS_FILE).exists() else []


def explain_loop_output(project: Project, name: str) -> Told:
    """What decides about an output of the closed loop, in the cases that have been simulated."""
    notes: list[str] = []
    worst: tuple[str, LoopOutput] | None = None
    for case_id, file in _files(project, SIMULATION, simulation_file_name, notes):
        for j in read_simulation(file).judged:
            if j.output == name and (worst is None or j.ratio > worst[1].ratio):
                worst = case_id, j
    rows, _ = _verdicts(project, SIMULATION, simulation_file_name, lambda output, _: output == name)
    tables = [Table("cases", _NOISE, rows, ranked=True)]
    if worst is None:
        notes.append("no simulation that is there judges it; its spectra are in the files of tedm simulate, /psd")
    else:
        case_id, j = worst
        by = {"groups": j.share, "sources": j.source_share, "areas": j.area_share, "disturbances": j.disturbance_share}
        for title, found in by.items():
            if title == "disturbances" and not found:
                continue
            columns = (Column(title[:-1]), Column("share", "share"))
            tables.append(Table(title, columns, by_share(found.items(), 1), ranked=True))
        at = f"{1e3 * j.binding_hz:.3g} mHz"
        notes.append(f"shares: of the PSD in case {case_id} at {at}, where the ratio is largest")
    return Told(name, "output of the drag-free loop", output_title(name), (f"unit {unit(name)}",), tuple(tables),
                tuple(notes))  # fmt: skip


def explain_loop_noise(project: Project, name: str) -> Told:
    """Level and origin of a noise source of the loop, or of a group of them, and its part of what is judged."""
    with open_checked(project.build_dir / DYNAMICS_FILE, DYNAMICS) as file:
        columns = (DYNAMICS.NOISE_NAME, DYNAMICS.NOISE_GROUP, DYNAMICS.NOISE_SPECTRUM, DYNAMICS.NOISE_ORIGIN)
        sources = [row for row in zip(*(file.strings(c) for c in columns), strict=True) if name in row[:2]]
    is_group = any(group == name for _, group, _, _ in sources) or name == THERMAL
    notes: list[str] = []
    rows: list[tuple[Cell, ...]] = []
    for case_id, opened in _files(project, SIMULATION, simulation_file_name, notes):
        for j in read_simulation(opened).judged:
            share = (j.share if is_group else j.source_share).get(name, 0.0)
            rows.append((j.output, j.requirement, case_id, share, j.ratio, j.silenced.get(name) if is_group else None))
    head = (Column("output"), Column("requirement"), Column("case"), Column("share", "share"), Column("ratio", "ratio"))
    without = (Column("without it", "ratio"),) if is_group else ()
    cut = len(head) + len(without)
    table = Table("outputs", (*head, *without), by_share([row[:cut] for row in rows], 3), ranked=True)
    facts = [f"{source}: {spectrum} (group {group}; {origin})" for source, group, spectrum, origin in sources]
    if name == THERMAL:
        facts.append("the temperatures of a case, by gravity, stiffness and read-out at once")
    notes.append("share: of the PSD where the ratio of the output is largest")
    sort = "group of noise sources of the drag-free loop" if is_group else "noise source of the drag-free loop"
    return Told(name, sort, name, tuple(facts), (table,), tuple(notes))


def _verdicts(
    project: Project,
    kind: FileKind,
    name_of: Callable[[str], str],
    wanted: Callable[[str, str], bool],
    ids: Sequence[str] | None = None,
) -> tuple[tuple[tuple[Cell, ...], ...], list[str]]:
    """The verdicts of all cases whose (output, requirement) is wanted, worst first, and what was passed over."""
    rows: list[tuple[Cell, ...]] = []
    notes: list[str] = []
    for case_id, file in _files(project, kind, name_of, notes, ids):
        columns = zip(
            file.strings(CASE.VERDICT_OUTPUT),
            file.strings(CASE.VERDICT_REQUIREMENT),
            file.array(CASE.VERDICT_RATIO).tolist(),
            file.array(CASE.VERDICT_BINDING_FREQUENCY).tolist(),
            file.array(CASE.VERDICT_PASSED).tolist(),
            strict=True,
        )
        role = file.string(CASE.CASE_ROLE)
        rows += [(o, q, case_id, role, ratio, hz, bool(ok)) for o, q, ratio, hz, ok in columns if wanted(o, q)]
    return by_size(rows, 4), notes


def _chances(project: Project, wanted: Callable[[str, str], bool], ids: Sequence[str] | None = None) -> Table:
    """Probabilities of a violation, largest first, and percentiles of the ratios; empty where nothing is uncertain."""
    found: list[tuple[str, Distribution]] = []
    for case_id, file in _files(project, CASE, case_file_name, [], ids):
        u = read_uncertainty(file)
        found += [(case_id, d) for d in (u.verdicts if u is not None else ()) if wanted(d.output, d.requirement)]
    found.sort(key=lambda item: (-item[1].violated.probability, -item[1].percentile(50)))
    rows: tuple[tuple[Cell, ...], ...] = tuple(
        (d.output, d.requirement, case_id, d.violated, d.violated_bare, *(d.percentile(q) for q in (5, 50, 95)))
        for case_id, d in found
    )
    return Table("probabilities", _CHANCES, rows, ranked=True)


def _files(
    project: Project,
    kind: FileKind,
    name_of: Callable[[str], str],
    notes: list[str],
    ids: Sequence[str] | None = None,
) -> Iterator[tuple[str, Reader]]:
    """The files of the configured cases that are there, open; what is stale or missing is put into the notes."""
    missing, stale = [], []
    for case_id in load_cases(project.cases)[1].ids if ids is None else ids:
        path = project.build_dir / name_of(case_id)
        if not path.exists():
            missing.append(case_id)
            continue
        with open_checked(path, kind) as file:
            try:
                require_configuration(file, project.cases)
            except InputError:
                stale.append(case_id)
                continue
            yield case_id, file
    for names, what in ((missing, "not run"), (stale, "run with another cases file, and passed over")):
        if names:
            notes.append(f"case {', '.join(names)}: {what}; `{kind.made_by} {names[0] if len(names) == 1 else 'all'}`")


def _at_rest_table(project: Project, name: str) -> Table:
    """The verdicts on the field at rest by a requirement; without them, its limits."""
    path = project.build_dir / SENSITIVITY_FILE
    if not path.exists():
        columns = (Column("quantity"), Column("field of"), Column("lower", "number"), Column("upper", "number"))
        limits = [(m.quantity, "+".join(m.subsystems) or ALL, m.lower, m.upper) for m in _at_rest(project)
                  if m.requirement == name]  # fmt: skip
        return Table("limits_at_rest", columns, tuple(limits))
    with open_checked(path, SENSITIVITY) as file:
        return verdict_table(file, lambda v: v.requirement == name)


def verdict_table(gravity: Reader, wanted: Callable[[DcVerdict], bool]) -> Table:
    """Those of the verdicts on the field at rest that are wanted, worst first."""
    rows = [
        (v.quantity, v.place, v.subsystem, v.value, v.limit, v.unit, v.ratio, v.passed)
        for v in dc_verdicts(gravity)
        if wanted(v)
    ]
    columns = (
        *(Column("at rest"), Column("on"), Column("field of"), Column("value", "number"), Column("limit", "number")),
        *(Column("unit"), Column("ratio", "ratio"), Column("verdict", "verdict")),
    )
    return Table("at_rest", columns, by_size(rows, 6), ranked=True)
