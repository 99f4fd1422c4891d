"""What is configured to be uncertain, as rows of the outputs, and what it makes of the verdicts of a case."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tedm_cli.arrays import BoolArray, FloatArray
from tedm_cli.config.cases import CasesConfig
from tedm_cli.config.correlation.uncertain import Pairs
from tedm_cli.config.model.areas import id_ranges
from tedm_cli.config.model.file import ModelConfig
from tedm_cli.config.project import Project
from tedm_cli.config.uncertainty import AXES, MaterialDeviation, MeshDeviation
from tedm_cli.contracts import ADJOINT, SENSITIVITY
from tedm_cli.errors import ConfigError, InputError
from tedm_cli.files.build_folder import ADJOINT_FILE, SENSITIVITY_FILE, require_configuration, require_input
from tedm_cli.files.provenance import input_files
from tedm_cli.files.store import open_checked
from tedm_cli.noise.areas import AreaTable
from tedm_cli.noise.case_run import CaseResult, judged_outputs
from tedm_cli.noise.differences import rows_of
from tedm_cli.noise.requirements import Criteria, in_band
from tedm_cli.noise.selection import BlockSelector, listed, select
from tedm_cli.noise.sources import AnyNoise
from tedm_cli.results.adjoint.derivatives import Derivatives, read_derivatives, read_position_rows
from tedm_cli.results.adjoint.within import CaseGradients
from tedm_cli.results.outputs import ModelOutputs
from tedm_cli.stages.noise.other_mesh import OtherMesh, other_mesh
from tedm_cli.uncertainty.parameters import EXPANSION, MESH, NORMAL, Parameter, Parameters
from tedm_cli.uncertainty.response import Effects, Ratio
from tedm_cli.uncertainty.verdicts import CaseUncertainty, Draws, Judged, MeshComparison, uncertainty

Problems = list[tuple[str, str]]
_NO_MATRIX = "positions of test masses and levels need none of it"
_WITHIN = "levels act on gradients within areas; how else these change is not known, and left out"
_NO_ADJOINT = "the project has no test masses, and the adjoint is of projects that have"


@dataclass(frozen=True, eq=False)
class Uncertain:
    """What is uncertain of n outputs: `effects` on them, what was left out, the other mesh, and the files read.

    `levels`: numbers of the parameters that are levels, and what areas they select.
    """

    effects: Effects
    levels: tuple[tuple[int, BlockSelector], ...]
    left_out: tuple[str, ...]
    draws: Draws
    mesh: OtherMesh | None
    sources: tuple[Path, ...]

    def of_case(self, result: CaseResult, criteria: Criteria) -> CaseUncertainty:
        """What it makes of the verdicts of a case, whose outputs these are."""
        outputs, f, factor = result.outputs, result.frequency_hz, result.safety_factor
        pairs = judged_outputs(criteria, outputs, f)
        noise = result.source.outputs(outputs.rows, f)
        effects, left_out = self.effects, list(self.left_out)
        if outputs.areas.within.any():
            within = outputs.areas.only(outputs.areas.within)
            effects = self._on(within)
            if len(self.levels) < len(effects.parameters.items):
                left_out.append(f"{listed(within.name.tolist())}: {_WITHIN}")
        judged, bands = [], []
        for (requirement, o), verdict in zip(pairs, result.verdicts, strict=True):
            band = f[in_band(requirement, f)]
            limit = requirement.amplitude(band) / factor
            ratio = Ratio(effects.response(outputs.rows[o], o), noise, band, limit)
            judged.append(Judged(verdict.output, verdict.requirement, verdict.ratio, ratio))
            bands.append((o, band, limit))
        mesh = None if self.mesh is None else _compared(self.mesh, noise, bands)
        return uncertainty(effects.parameters, judged, factor, self.draws, left_out, mesh)

    def _on(self, within: AreaTable) -> Effects:
        """The effects, on gradients within areas as well: of these the levels that select them."""
        level = np.zeros((len(self.effects.parameters.items), len(within)), dtype=bool)
        for p, selector in self.levels:
            level[p] = select(selector, within)[0]  # what no area of this case has was held against all of them before
        return self.effects.and_areas(level)


def _compared(mesh: OtherMesh, noise: AnyNoise, bands: Sequence[tuple[int, FloatArray, FloatArray]]) -> MeshComparison:
    """The ratios by the other mesh, and by both: of each verdict its output, its frequencies and limit."""

    def ratios(rows: FloatArray) -> FloatArray:
        psd = [(noise.of(rows[o : o + 1]).at(band).psd()[0], limit) for o, band, limit in bands]
        return np.array([(np.sqrt(power) / limit).max() for power, limit in psd])

    k = mesh.rows.shape[1]  # behind them are gradients within areas, of which the other mesh tells nothing
    there, none = noise.rows.copy(), noise.rows.copy()
    there[:, :k] = mesh.rows
    none[:, :k] += mesh.estimate
    return MeshComparison(mesh.name, mesh.refinement, mesh.order, ratios(there), ratios(none))


def uncertain(
    project: Project,
    model: ModelConfig,
    cases: CasesConfig,
    outputs: ModelOutputs,
    gradients: CaseGradients,
    compare: MeshDeviation | None = None,
) -> Uncertain | None:
    """Gather what is uncertain; None where nothing is configured.

    `gradients` are those within areas that cases have; `compare`: another mesh, in place of the one that the cases file
    may name.

    Raises
    ------
    ConfigError : materials, properties or areas that are not in the model; a relative deviation of no expansion; a
        parameter that is named twice.
    InputError : adjoint.h5 or the other mesh is stale, or is of other outputs or areas.
    """
    of_model, of_cases = model.uncertainty, cases.uncertainty
    mesh_table = compare if compare is not None else of_cases.mesh
    if not (of_model.of_structure or of_model.test_mass or of_cases.level or mesh_table):
        return None
    sources: list[Path] = []
    found, left_out = _Found(outputs), []
    if of_model.of_structure:
        path = project.build_dir / ADJOINT_FILE
        derivatives = _derivatives(project, path, outputs) if model.test_mass else _NO_ADJOINT
        sources += [path] if path.exists() else []  # where it tells why there is none, too
        if isinstance(derivatives, str):
            left_out.append(f"{', '.join(of_model.names_of_structure)}: {derivatives}")
        else:
            _add_structure(found, model, derivatives, project.model)
    _add_positions(found, project, model)
    kept = {item.name for item in found.items}
    parameters = Parameters.of(tuple(found.items), _among(of_model.pairs(), kept))
    levels = _Found(outputs)
    selectors = _add_levels(levels, cases, project.cases, kept.union(of_model.names_of_structure), gradients)
    numbered = tuple(enumerate(selectors, len(found.items)))
    named = {item.name for item in levels.items}
    parameters += Parameters.of(tuple(levels.items), _among(of_cases.pairs(), named))
    found.extend(levels)
    mesh = None
    if mesh_table is not None:
        mesh = other_mesh(project, mesh_table, outputs)
        sources += mesh.sources
        item = Parameter(MESH, MESH, f"error of the mesh by {mesh.name}", mesh_table.sigma, NORMAL)
        parameters += Parameters.of((item,))
        found.add(item, mesh.estimate)
    effects = Effects(parameters, found.changes(), found.levels())
    draws = Draws(of_cases.samples, of_cases.seed)
    return Uncertain(effects, numbered, tuple(left_out), draws, mesh, tuple(sources))


class _Found:
    """Parameters as they are found, each with its rows [n, k] of the outputs or its areas [k]."""

    def __init__(self, outputs: ModelOutputs) -> None:
        self.outputs = outputs
        self.items: list[Parameter] = []
        self._change: list[FloatArray] = []
        self._level: list[BoolArray] = []

    def add(self, item: Parameter, change: FloatArray | None = None, level: BoolArray | None = None) -> None:
        """A parameter with the rows of its change, or with the areas that it multiplies."""
        self.items.append(item)
        self._change.append(np.zeros_like(self.outputs.rows) if change is None else change)
        self._level.append(np.zeros(len(self.outputs.areas), dtype=bool) if level is None else level)

    def extend(self, other: _Found) -> None:
        """With those of another."""
        self.items += other.items
        self._change += other._change
        self._level += other._level

    def changes(self) -> FloatArray:
        """[p, n, k]."""
        return np.array(self._change).reshape(len(self.items), *self.outputs.rows.shape)

    def levels(self) -> BoolArray:
        """[p, k]."""
        return np.array(self._level, dtype=bool).reshape(len(self.items), len(self.outputs.areas))


def _among(pairs: Pairs, names: set[str]) -> Pairs:
    """The pairs of parameters that were not left out."""
    return {pair: rho for pair, rho in pairs.items() if names.issuperset(pair)}


def _derivatives(project: Project, path: Path, outputs: ModelOutputs) -> Derivatives | str:
    """Those of adjoint.h5, or why there are none."""
    if not path.exists():
        return f"{path} is not there: `{ADJOINT.made_by}` makes it; {_NO_MATRIX}"
    with open_checked(path, ADJOINT) as file:
        require_configuration(file, project.model)
        for item in input_files(outputs.matrices):
            require_input(file, item)
        found = read_derivatives(file)
        if isinstance(found, str):
            return f"there is no adjoint of this model: {found}"
        lacks = [label for label in outputs.labels if "-" not in label and label not in found.label]
        if lacks:
            hint = f"rebuild it with `{ADJOINT.made_by}`, or `tedm run`"
            raise InputError(f"is stale: it has no row {lacks[0]}", where=str(path), hint=hint)
        return found


def _add_structure(found: _Found, model: ModelConfig, by: Derivatives, where: Path) -> None:
    """Materials and thicknesses."""
    labels = found.outputs.labels

    def rows(part: FloatArray) -> FloatArray:
        return rows_of(labels, dict(zip(by.label, part.sum(axis=0), strict=True)))

    problems: Problems = []
    taken: dict[tuple[str, int], str] = {}

    def take(quantity: str, ids: Sequence[int], place: str) -> None:
        for number in ids:
            before = taken.setdefault((quantity, number), place)
            if before != place:
                what = "thickness of property" if quantity == "thickness" else f"{quantity} of material"
                problems.append((place, f"the {what} {number} is uncertain already in {before}"))

    for i, table in enumerate(model.uncertainty.material):
        place = f"uncertainty.material[{i}]"
        chosen, facts = _materials(table, by, place)
        ids = by.material[chosen].tolist()
        if table.of == EXPANSION and table.relative:
            facts += [
                (
                    place,
                    f"material {mid} has no expansion that could deviate by a part of it; give absolute_sigma_per_K",
                )
                for mid, expansion in zip(ids, by.expansion[chosen].tolist(), strict=True)
                if expansion == 0.0
            ]
        problems += facts
        take(table.of, ids, place)
        change = by.by_logarithm[table.of] if table.relative else by.by_expansion
        of = ", ".join(f"{card} {mid}" for card, mid in zip(by.card, by.material, strict=True) if mid in ids)
        found.add(table.parameter(of), rows(change[chosen]))
    for i, shell in enumerate(model.uncertainty.shell):
        place = f"uncertainty.shell[{i}]"
        chosen, facts = _chosen(
            id_ranges(shell.property), by.shell_id.tolist(), "property of shells", f"{place}.property"
        )
        problems += facts
        ids = by.shell_id[chosen].tolist()
        take(shell.quantity, ids, place)
        found.add(shell.parameter(", ".join(f"PSHELL {pid}" for pid in ids)), rows(by.by_thickness[chosen]))
    if problems:
        raise ConfigError(problems, where=str(where))


def _materials(table: MaterialDeviation, by: Derivatives, place: str) -> tuple[BoolArray, Problems]:
    """Mask [m] of the materials of a table, and ids that are not in the deck."""
    if table.material is not None:
        return _chosen(id_ranges(table.material), by.material.tolist(), "material", f"{place}.material")
    ranges = id_ranges(table.property)
    _, facts = _chosen(ranges, by.properties, "property", f"{place}.property")
    return by.materials_of(_in(ranges)), facts


def _in(ranges: Sequence[tuple[int, int]]) -> Callable[[int], bool]:
    return lambda number: any(low <= number <= high for low, high in ranges)


def _chosen(
    ranges: Sequence[tuple[int, int]], there: Sequence[int], what: str, place: str
) -> tuple[BoolArray, Problems]:
    """Mask of the ids `there` that ranges choose, and the ranges that choose none."""
    known = ", ".join(map(str, there[:12])) + (f" and {len(there) - 12} more" if len(there) > 12 else "")
    facts = [
        (place, f"elements of the deck have no {what} {_range(low, high)}; they have: {known or 'none'}")
        for low, high in ranges
        if not any(low <= number <= high for number in there)
    ]
    return np.array([_in(ranges)(number) for number in there], dtype=bool), facts


def _range(low: int, high: int) -> str:
    return f"{low}" if low == high else f"{low}:{high}"


def _add_positions(found: _Found, project: Project, model: ModelConfig) -> None:
    """Positions of test masses: of self-gravity; the read-outs stay."""
    tables = model.uncertainty.test_mass
    if not tables:
        return
    path = project.build_dir / SENSITIVITY_FILE
    with open_checked(path, SENSITIVITY) as file:
        for table in tables:
            for axis, name in zip(table.axes, table.names(), strict=True):
                rows = read_position_rows(file, table.test_mass, AXES.index(axis))
                if rows is None:
                    hint = f"rebuild it with `{SENSITIVITY.made_by}`, or `tedm run`"
                    raise InputError("is stale: it has no derivatives by positions", where=str(path), hint=hint)
                still = np.zeros(len(found.outputs.areas))
                known = {label: rows.get(label, still) for label in found.outputs.labels if "-" not in label}
                item = table.parameter(f"{table.test_mass} along {axis}", name)
                found.add(item, rows_of(found.outputs.labels, known))


def _add_levels(
    found: _Found, cases: CasesConfig, where: Path, taken: set[str], gradients: CaseGradients
) -> list[BlockSelector]:
    """Levels of the temperatures, with what they select: of the model's areas, and of gradients within areas."""
    problems: Problems = []
    areas = found.outputs.areas
    for more in gradients.tables.values():
        if (fresh := ~np.isin(more.areas.name, areas.name)).any():
            areas = areas.and_last(more.areas.only(fresh))
    selectors = [table.chosen() for table in cases.uncertainty.level]
    for i, (table, selector) in enumerate(zip(cases.uncertainty.level, selectors, strict=True)):
        place = f"uncertainty.level[{i}]"
        mask, facts = select(selector, areas)
        if facts and gradients.refusal is not None:  # it may be these that are meant
            raise gradients.refusal
        problems += [(f"{place}{key}", fact) for key, fact in facts]
        if table.name in taken:
            problems.append((f"{place}.name", f"{table.name!r} is the name of a parameter of the model already"))
        found.add(table.parameter(table.words), level=mask[: len(found.outputs.areas)])
    if problems:
        raise ConfigError(problems, where=str(where))
    return selectors
