"""The judged outputs of a build folder as sums over points of a temperature field, and the areas that it has now."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tedm_cli.adjoint.area_points import area_points
from tedm_cli.adjoint.areas import Places, Temperatures, Warmed
from tedm_cli.adjoint.connected import joining, sharing_an_element
from tedm_cli.adjoint.mirrored import images
from tedm_cli.adjoint.temperature_field import FieldPoints
from tedm_cli.arrays import BoolArray, FloatArray, IntArray
from tedm_cli.config.cases import CasesConfig, load_cases
from tedm_cli.config.project import Project
from tedm_cli.config.temperature.tables import temperature_model
from tedm_cli.contracts import ADJOINT, UNIT_LOADS
from tedm_cli.errors import ConfigError, InputError
from tedm_cli.files.build_folder import (
    ADJOINT_FILE,
    SENSITIVITY_FILE,
    UNIT_LOADS_FILE,
    provenance,
    require_configuration,
    require_input,
)
from tedm_cli.files.store import Reader, open_checked
from tedm_cli.noise.areas import AreaTable
from tedm_cli.noise.case_run import judged_outputs
from tedm_cli.noise.correlation import CorrelationCase
from tedm_cli.noise.differences import terms
from tedm_cli.noise.requirements import in_band
from tedm_cli.noise.told_apart import paired, told_apart
from tedm_cli.results.areas import read_areas
from tedm_cli.results.outputs import read_outputs


@dataclass(frozen=True, eq=False, kw_only=True)
class ModelField:
    """The points of a temperature field, and what areas of them there are now.

    outputs : [r], labels of the judged outputs. frequency_hz : [r], of their temperatures. ratio_per_deviation : [r],
    ratio to the requirement there by the standard deviation of what the points make of a field of variance 1.
    points : of the field: grids, then elements with a temperature of their own. area : [n], their area now.
    grid : rows of the grids among all of the model, [g], of the first g points.
    kept : [k], areas that stay as they are: those with elements of their own, and gradients.
    pairs : [p, 2], points that an area may have together if it has one: grids that share an element, in parts that the
    cases do not tell apart.
    image : [n], the mirror image of each point where a case pairs areas by them, -1 of the others.
    areas : the present ones. cases : of correlation. members : [k], rows of all grids of each area.
    """

    outputs: list[str]
    frequency_hz: FloatArray
    ratio_per_deviation: FloatArray
    points: FieldPoints
    area: IntArray
    grid: IntArray
    kept: BoolArray
    pairs: IntArray
    image: IntArray
    areas: AreaTable
    cases: list[CorrelationCase]
    members: list[IntArray]
    grid_id: IntArray
    position: FloatArray

    @property
    def free(self) -> BoolArray:
        """Points [n] whose area may change."""
        return np.asarray(~self.kept[self.area])


def model_field(project: Project, *, even: bool) -> ModelField:
    """Read the adjoint, the mesh and the cases of a project.

    With `even` the field has one amplitude everywhere; otherwise that of the temperatures in the cases file, at the
    frequency where each output is nearest to its requirement when all areas are uncorrelated.

    Raises
    ------
    InputError : a file that is missing or stale; a model without an adjoint here.
    ConfigError : nothing is judged; a cases file that does not fit the model.
    """
    build = project.build_dir
    paths = [build / name for name in (ADJOINT_FILE, UNIT_LOADS_FILE, SENSITIVITY_FILE)]
    trace = provenance([], paths)
    with open_checked(paths[0], ADJOINT) as adjoint, open_checked(paths[1], UNIT_LOADS) as unit:
        require_configuration(adjoint, project.model)
        for item in trace.inputs[1:]:
            require_input(adjoint, item)
        if adjoint.has(ADJOINT.REFUSAL):
            raise InputError("; ".join(adjoint.strings(ADJOINT.REFUSAL)), where=str(paths[0]))
        config = load_cases(project.cases)[1]
        judged = _judged(project, config, adjoint, even=even)
        cases = [config.case(i, where=str(project.cases)) for i in config.ids_of_areas]
        return _gathered(adjoint, unit, judged, cases)


@dataclass(frozen=True, eq=False)
class _Judged:
    """outputs, frequency_hz, ratio_per_deviation : as of `ModelField`. amplitude : [r, k], 1 where it is largest."""

    outputs: list[str]
    frequency_hz: FloatArray
    ratio_per_deviation: FloatArray
    amplitude: FloatArray


def _judged(project: Project, config: CasesConfig, adjoint: Reader, *, even: bool) -> _Judged:
    """The judged outputs at their frequencies, and how the amplitude of the field differs from area to area there."""
    criteria, f = config.criteria(), config.frequency_hz()
    outputs = read_outputs(project).with_differences(criteria.requirements)
    judged = judged_outputs(criteria, outputs, f)
    known = adjoint.strings(ADJOINT.ROW_LABEL)
    judged = [(q, o) for q, o in judged if all(t in known for t in terms(outputs.labels[o]) or [outputs.labels[o]])]
    if not judged:
        fact = "names no output that the adjoint has" if criteria.requirements else "there is none: nothing is judged"
        raise ConfigError([("requirement", fact)], where=str(project.cases))
    temperature = temperature_model(project, config, outputs.areas)
    mean = ~outputs.areas.gradient
    nearest: dict[int, tuple[float, float, float]] = {}  # by output: ratio, frequency, limit
    for requirement, o in judged:
        band = f[in_band(requirement, f)]
        noise = np.sqrt(((outputs.rows[o, mean, None] * temperature.amplitudes(band)[mean]) ** 2).sum(axis=0))
        limit = requirement.amplitude(band)
        at = int((noise / limit).argmax())
        found = float(noise[at] / limit[at]), float(band[at]), float(limit[at])
        nearest[o] = max(nearest.get(o, found), found)
    _, frequency, limit = np.array(list(nearest.values())).T
    amplitude = temperature.amplitudes(frequency).T
    largest = amplitude[:, mean].max(axis=1)
    relative = np.divide(amplitude, largest[:, None], out=np.ones_like(amplitude), where=largest[:, None] > 0.0)
    return _Judged(
        [outputs.labels[o] for o in nearest],
        frequency,
        criteria.safety_factor * largest / limit,
        np.ones_like(relative) if even else relative,
    )


def _rows(adjoint: Reader, outputs: list[str], values: FloatArray) -> FloatArray:
    """Of values [rows, ...] of the adjoint those of the outputs, [r, ...], differences among them."""
    place = {label: i for i, label in enumerate(adjoint.strings(ADJOINT.ROW_LABEL))}
    pairs = [terms(label) for label in outputs]
    return np.array(
        [
            values[place[label]] if pair is None else values[place[pair[0]]] - values[place[pair[1]]]
            for label, pair in zip(outputs, pairs, strict=True)
        ]
    )


def _gathered(adjoint: Reader, unit: Reader, judged: _Judged, cases: list[CorrelationCase]) -> ModelField:
    outputs, amplitude = judged.outputs, judged.amplitude
    areas, position, grid_id = read_areas(unit), unit.array(UNIT_LOADS.GRID_POSITION), unit.array(UNIT_LOADS.GRID_ID)
    offset, index = unit.array(UNIT_LOADS.ELEMENT_NODE_OFFSET), unit.array(UNIT_LOADS.ELEMENT_NODE_INDEX)
    members = _parts(unit.array(UNIT_LOADS.AREA_NODE_INDEX), unit.array(UNIT_LOADS.AREA_NODE_OFFSET))
    carried = _parts(unit.array(UNIT_LOADS.AREA_ELEMENT_INDEX), unit.array(UNIT_LOADS.AREA_ELEMENT_OFFSET))
    number = adjoint.array(ADJOINT.ELEMENT_ID)
    row_of = np.full(int(number.max(initial=0)) + 1, -1)
    row_of[number] = np.arange(len(number))
    ids = unit.array(UNIT_LOADS.ELEMENT_ID)
    warmed = [
        Warmed(grid=m, element=row_of[ids[c]], gradient=np.zeros((len(c), 2)) if gradient else None)
        for m, c, gradient in zip(members, carried, areas.gradient.tolist(), strict=True)
    ]
    rows = [_rows(adjoint, outputs, adjoint.array(d)) for d in (ADJOINT.S, ADJOINT.ELEMENT_MEAN, ADJOINT.DIRECT)]
    own = adjoint.array(ADJOINT.ELEMENT_OWN) == 1
    at_element = np.searchsorted(ids, number)
    centre = np.add.reduceat(position[index], offset[:-1], axis=0)[at_element] / np.diff(offset)[at_element, None]
    found = area_points(
        Temperatures(grid=rows[0], own=own, mean=rows[1], gradient=np.zeros((*rows[1].shape, 2))),
        rows[2],
        warmed,
        Places(
            grid=position,
            grid_volume=adjoint.array(ADJOINT.GRID_VOLUME),
            element=centre,
            element_volume=adjoint.array(ADJOINT.ELEMENT_VOLUME),
        ),
    )
    points, area, grid = found.points, found.area, found.grid
    owner = np.full(len(grid_id), -1)
    owner[grid] = area[: len(grid)]
    kept = np.array([bool(c.size) for c in carried]) | areas.gradient
    part = np.where((owner >= 0) & ~kept[owner], told_apart(areas, cases, amplitude)[owner], -1)
    pairs = sharing_an_element(offset, index, part)
    row = np.full(len(grid_id), -1)
    row[grid] = np.arange(len(grid))
    pairs = row[pairs]
    pairs = pairs[(pairs >= 0).all(axis=1)]
    free = np.flatnonzero(~kept[area])
    image = images(points.position, areas.plane, (paired(areas, cases) & ~kept)[area])
    return ModelField(
        outputs=outputs,
        frequency_hz=judged.frequency_hz,
        ratio_per_deviation=judged.ratio_per_deviation,
        points=replace(points, sensitivity=points.sensitivity * amplitude[:, area]),
        area=area,
        grid=grid,
        kept=kept,
        pairs=np.concatenate([pairs, free[joining(_among(pairs, free), points.position[free], area[free])]]),
        image=np.full(len(area), -1) if image is None else image,
        areas=areas,
        cases=cases,
        members=members,
        grid_id=grid_id,
        position=position,
    )


def _parts(index: IntArray, offset: IntArray) -> list[IntArray]:
    return np.split(index, offset[1:-1])


def _among(pairs: IntArray, chosen: IntArray) -> IntArray:
    """Pairs of rows as pairs of places among the `chosen` rows, which ascend and have them all."""
    return np.asarray(np.searchsorted(chosen, pairs))
