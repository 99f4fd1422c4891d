"""The thermal nodes that lie on the finite elements, and what a kelvin of each does to the outputs."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.config.project import Project
from tedm_cli.config.thermal.file import ThermalConfig
from tedm_cli.config.thermal.map import MapTable
from tedm_cli.contracts import ADJOINT
from tedm_cli.errors import InputError
from tedm_cli.files.build_folder import ADJOINT_FILE, require_configuration, require_input
from tedm_cli.files.provenance import ConfigFile, input_files
from tedm_cli.files.store import open_checked
from tedm_cli.mapping.averages import NONE, averages
from tedm_cli.mapping.node_map import ConductedMap, WeightedMap
from tedm_cli.results.adjoint.file import read_adjoint
from tedm_cli.results.adjoint.temperatures import TemperatureEffects, read_temperature_effects
from tedm_cli.stages.thermal.map_build import Mapping, build_map
from tedm_cli.stages.thermal.map_model import FiniteElements, finite_elements


@dataclass(frozen=True, eq=False)
class NodeSensitivity:
    """Outputs per kelvin of each thermal node of the map; none where `why` says why there are none.

    node : [n_m] names; [] where the map has not been made. grid_id : [N], of the model. through : from temperatures
    of the nodes to those of the grids; none where the map has not been made. area : [n_m], the thermal area that most
    of each is in, or "". label, unit : [r], of the outputs. value : [r, n_m]. configs, inputs : what it is made of, for
    the provenance of the file.
    """

    node: list[str]
    grid_id: IntArray
    through: ConductedMap | WeightedMap | None
    area: list[str]
    label: list[str]
    unit: list[str]
    value: FloatArray
    configs: tuple[ConfigFile, ...]
    inputs: tuple[Path, ...]
    why: str = ""


def node_sensitivity(project: Project, config: ThermalConfig) -> NodeSensitivity | None:
    """The sensitivities; None where the project has no map.

    Without adjoint.h5, or with one that says why there is no adjoint, none of them: then the map is made where the
    project has no network, which is all that there is to be made.

    Raises
    ------
    InputError : adjoint.h5 is stale, or of other grids than the model; what `finite_elements` and `build_map` refuse.
    """
    path = project.build_dir / ADJOINT_FILE
    if config.map is None:
        return None
    if not path.exists():
        return _without(project, config, config.map, f"{path} is not there (`{ADJOINT.made_by}` makes it)", ())
    with open_checked(path, ADJOINT) as file:
        require_configuration(file, project.model)
        found = read_temperature_effects(file)
        if found is None:
            return _without(project, config, config.map, f"{path}: {read_adjoint(file)}", (path,))
        fem = finite_elements(project, solved=True)
        for used in input_files(fem.files):
            require_input(file, used)
    if not np.array_equal(found.grid_id, fem.geometry.grid_id):
        raise InputError(
            f"is of {len(found.grid_id)} grids, and not of the {len(fem.geometry.grid_id)} of {fem.source}",
            where=str(path),
            hint="is the deck of another state of the model? `tedm run` brings both up to date",
        )
    where = project.required_thermal()
    mapping = build_map(fem, config.map, where)
    return NodeSensitivity(
        node=mapping.node,
        grid_id=fem.geometry.grid_id,
        through=mapping.through,
        area=areas_of_nodes(mapping),
        label=found.label,
        unit=found.unit,
        value=sensitivity(mapping, found),
        configs=(fem.config_file,),
        inputs=(*(project.beside(where, name) for name in config.map.file_names()), *fem.files, path),
    )


def _without(
    project: Project, config: ThermalConfig, table: MapTable, why: str, used: tuple[Path, ...]
) -> NodeSensitivity:
    """The map without sensitivities, `why`; without its nodes, too, where there is a network."""
    empty = np.zeros((0, 0))
    if config.network is not None:
        no_grids = np.zeros(0, dtype=np.int64)
        return NodeSensitivity([], no_grids, None, [], [], [], empty, (), used, why)
    fem, where = finite_elements(project, solved=True), project.required_thermal()
    mapping = build_map(fem, table, where)
    inputs = (*(project.beside(where, name) for name in table.file_names()), *fem.files, *used)
    return NodeSensitivity(
        node=mapping.node,
        grid_id=fem.geometry.grid_id,
        through=mapping.through,
        area=areas_of_nodes(mapping),
        label=[],
        unit=[],
        value=empty,
        configs=(fem.config_file,),
        inputs=inputs,
        why=why,
    )


def sensitivity(mapping: Mapping, found: TemperatureEffects) -> FloatArray:
    """Outputs per kelvin of the nodes [r, n].

    With weights, the columns of the areas with these. Else what a mapped field on the grids does: all elements take the
    temperatures of their grids, those with temperatures of their own in some area too. What does not pass through the
    structure follows the average over its area.
    """
    if mapping.weights is not None:
        names = [str(name) for name in found.areas.name]
        columns = [names.index(name) for name in mapping.fem.areas]
        return np.asarray(found.of_area[:, columns] @ mapping.weights)
    return mapping.through.sensitivities(on_grids(found, mapping))


def areas_of_nodes(mapping: Mapping) -> list[str]:
    """The thermal area [n] that has most of each node: of its volume, or with weights the largest; "" where none has.

    Of areas with as much of it, the first counts.
    """
    fem, n = mapping.fem, len(mapping.node)
    names = list(fem.areas)
    if mapping.weights is not None:
        part = mapping.weights
    else:
        assert mapping.association is not None
        area, node = fem.place_area(), mapping.association.place_node
        both = (area != NONE) & (node != NONE)
        part = np.zeros((len(names), n))
        np.add.at(part, (area[both], node[both]), fem.volumes.volume[both])
    return [names[most] if part[most, i] > 0.0 else "" for i, most in enumerate(part.argmax(axis=0).tolist())]


def on_grids(found: TemperatureEffects, mapping: Mapping) -> FloatArray:
    """What temperatures of grids [r, N] do where these are all there are."""
    fem = mapping.fem
    offset, index = fem.geometry.elements.node_offset, fem.geometry.elements.node_index
    out = found.grid.copy()
    for row, element in enumerate(np.searchsorted(fem.geometry.elements.id, found.own_id).tolist()):
        grids = index[offset[element] : offset[element + 1]]
        out[:, grids] += found.own[:, [row]] / len(grids)
    return out + _direct(found, fem, mapping)


def _direct(found: TemperatureEffects, fem: FiniteElements, mapping: Mapping) -> FloatArray:
    """The direct parts [r, N] as averages over the areas; those of areas that are not mapped stay with these."""
    names = [str(name) for name in found.areas.name]
    acting = [name for name in fem.areas if found.direct[:, names.index(name)].any()]
    out = np.zeros_like(found.grid)
    if not acting:
        return out
    areas, of, mapped = list(fem.areas), fem.volumes, mapping.through.mapped
    place = fem.place_area()
    mean = averages(of, np.where(mapped[of.node_index], place, NONE), len(areas), len(mapped))
    for name in acting:
        out += found.direct[:, [names.index(name)]] * mean[[areas.index(name)]].toarray()
    return out
