"""Outputs by thermal nodes in place of areas, as thermal.h5 has them: for cases of the network and for series."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tedm_cli.arrays import BoolArray, FloatArray, IndexArray
from tedm_cli.config.project import Project
from tedm_cli.config.thermal.file import ThermalConfig, load_thermal
from tedm_cli.contracts import ADJOINT, THERMAL
from tedm_cli.errors import ConfigError, InputError
from tedm_cli.files.build_folder import ADJOINT_FILE, THERMAL_FILE, require_configuration, require_input
from tedm_cli.files.provenance import input_files
from tedm_cli.files.store import Reader, open_checked
from tedm_cli.noise.areas import AreaTable
from tedm_cli.noise.selection import listed
from tedm_cli.results.outputs import ModelOutputs
from tedm_cli.results.thermal.file import require_thermal
from tedm_cli.results.wording import count

NO_AREA = "no area"
"""Group of thermal nodes of which nothing is in a thermal area; they count as outside the shield, on neither side."""

REBUILD = f"`{THERMAL.made_by}`, or `tedm run`"
"""What makes thermal.h5, in hints."""


@dataclass(frozen=True, eq=False)
class NodeOutputs:
    """Outputs by the nodes of the map, and last by the areas that it leaves out and gradient areas.

    rows : of further outputs [n, k] by their labels. network : names of all nodes of the network, none without one.
    source : the file that they are from.
    """

    outputs: ModelOutputs
    network: frozenset[str]
    left: IndexArray
    source: Path


@contextlib.contextmanager
def open_nodes(project: Project, outputs: ModelOutputs, who: str) -> Iterator[tuple[ThermalConfig, Reader]]:
    """The thermal model's file and thermal.h5, which has sensitivities to nodes and fits the project as it is now.

    outputs : of the model's areas, without differences. who : takes them, in messages: `case T`, `series warm`.

    Raises
    ------
    ConfigError : a project without a thermal model or without a map; effects of the user's own, which follow areas.
    InputError : thermal.h5 is missing, stale, or without sensitivities.
    """
    if project.thermal is None:
        fact = f'has no thermal model (thermal = "thermal.toml"), whose nodes {who} is of'
        raise ConfigError([("thermal", fact)], where=str(project.file.path))
    thermal = load_thermal(project.thermal)[1]
    if thermal.map is None:
        raise ConfigError([("", f"has no [map], which {who} is made of")], where=str(project.thermal))
    if outputs.effects is not None:
        fact = (
            f"{count(len(outputs.effects.names), 'effect')} of the user's own ({listed(outputs.effects.names)})"
            f" are given by areas, and {who} has thermal nodes, which can have none"
        )
        raise ConfigError([("effect", fact)], where=str(project.model))
    path = project.build_dir / THERMAL_FILE
    if not path.exists():
        raise InputError(f"no such file; {who} of {project.cases} is made of it", where=str(path),
                         hint=f"make it with {REBUILD}")  # fmt: skip
    with open_checked(path, THERMAL) as file:
        _require_fresh(file, project, thermal, outputs)
        yield thermal, file


def node_outputs(project: Project, outputs: ModelOutputs, who: str) -> NodeOutputs:
    """Outputs by thermal nodes; arguments and errors as `open_nodes`, and `InputError` for outputs that it lacks."""
    with open_nodes(project, outputs, who) as (thermal, file):
        left = left_out(thermal, outputs.areas, np.ones(len(outputs.areas), dtype=bool))
        network = file.strings(THERMAL.NODE_NAME) if file.has(THERMAL.NODE_NAME) else []
        return NodeOutputs(outputs_by_nodes(file, outputs, left)[0], frozenset(network), left, file.path)


def left_out(thermal: ThermalConfig, areas: AreaTable, heard: BoolArray) -> IndexArray:
    """The areas that the map leaves out, and gradient areas, as far as they are among `heard` [k]."""
    assert thermal.map is not None
    unmapped = {name.upper() for name in thermal.map.unmapped}
    return np.flatnonzero((np.isin(np.char.upper(areas.name), list(unmapped)) | areas.gradient) & heard)


def outputs_by_nodes(file: Reader, outputs: ModelOutputs, left: IndexArray) -> tuple[ModelOutputs, IndexArray]:
    """The outputs by the nodes of thermal.h5 and by the areas `left`, and the area of each such column; -1: none.

    A node has the group, shield and side of the area that most of it is in.

    Raises
    ------
    InputError : the file lacks outputs.
    """
    nodes, model = file.strings(THERMAL.MAP_NODE), outputs.areas
    of_nodes = _areas(file, nodes, model)
    areas = of_nodes.and_last(model.only(np.isin(np.arange(len(model)), left))) if left.size else of_nodes
    rows = np.concatenate([node_rows(file, outputs.labels), outputs.rows[:, left]], axis=1)
    by_nodes = replace(outputs, areas=areas, rows=rows, parts_of_read_outs={}, area_id=np.arange(1, len(areas) + 1))
    return by_nodes, np.concatenate([_in_areas(file, model), left])


def node_rows(file: Reader, wanted: Sequence[str]) -> FloatArray:
    """Sensitivities [n, n_m] of outputs of these labels to the nodes; `InputError` where the file lacks one."""
    labels = file.strings(THERMAL.ROW_LABEL)
    missing = [label for label in wanted if label not in labels]
    if missing:
        raise InputError(f"was made without {listed(missing)}", where=str(file.path), hint=f"rebuild it with {REBUILD}")
    return file.array(THERMAL.SENSITIVITY)[[labels.index(label) for label in wanted]]


def _require_fresh(file: Reader, project: Project, thermal: ThermalConfig, outputs: ModelOutputs) -> None:
    """Refuse thermal.h5 made from other files than the project has now.

    The cases file may have changed, where it gave the frequencies: these are compared themselves.
    """
    require_thermal(file, project, thermal)
    if not file.has(THERMAL.SENSITIVITY):
        raise InputError(
            "has no /sensitivity: there was no adjoint.h5, or one that says why there is none",
            where=str(file.path),
            hint=f"`{ADJOINT.made_by}`, then {REBUILD}",
        )
    require_configuration(file, project.model)
    adjoint = project.build_dir / ADJOINT_FILE
    if adjoint.exists():
        with open_checked(adjoint, ADJOINT) as made_of:
            for used in input_files(outputs.matrices):
                require_input(made_of, used)


def _areas(file: Reader, nodes: Sequence[str], model: AreaTable) -> AreaTable:
    """The nodes as areas: with group, shield and side of the area that most of each is in."""
    at = _in_areas(file, model).tolist()

    def of(column: NDArray[np.str_], otherwise: str) -> NDArray[np.str_]:
        return np.array([otherwise if i < 0 else str(column[i]) for i in at])

    return AreaTable(
        np.array(nodes),
        of(model.group, NO_AREA),
        of(model.shield, "outside"),
        of(model.side, "mid"),
        plane=model.plane,
    )


def _in_areas(file: Reader, model: AreaTable) -> IndexArray:
    """The area of the model [n] that each node is in; -1: none."""
    names = model.name.tolist()
    return np.array([names.index(a) if a in names else -1 for a in file.strings(THERMAL.MAP_AREA)], dtype=np.intp)
