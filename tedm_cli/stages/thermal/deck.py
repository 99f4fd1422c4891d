"""write-deck --thermal-nodes: a field of temperatures for each thermal node, for another Nastran to solve."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tedm_cli.config.project import Project
from tedm_cli.config.thermal.file import load_thermal
from tedm_cli.errors import ConfigError, InputError
from tedm_cli.files.store import replacing
from tedm_cli.nastran.loads.node_deck import node_deck, verify_node_deck
from tedm_cli.nastran.loads.unit_deck import read_source
from tedm_cli.stages.thermal.displacements import node_fields
from tedm_cli.stages.thermal.map_build import build_map
from tedm_cli.stages.thermal.map_model import finite_elements

_NAME = "thermal_nodes.bdf"


@dataclass(frozen=True)
class NodeDeckSummary:
    """What was written: the nodes with a subcase, the number of grids that they warm, and what to know."""

    path: Path
    nodes: list[str]
    grids: int
    notes: tuple[str, ...]


def write_node_deck(project: Project, output: Path | None) -> NodeDeckSummary:
    """Write the deck of the thermal nodes of the map, and read it back before it is put in place.

    Raises
    ------
    ConfigError : a project without a map, or with one by weights, which needs no solution.
    InputError, PhysicsError : what `build_map` and `node_deck` refuse.
    """
    where = project.required_thermal()
    _, config = load_thermal(where)
    if config.map is None:
        raise ConfigError([("map", "is missing: nothing says where the thermal nodes are")], where=str(where))
    if config.map.weights is not None:
        fact = "has the displacements of areas, weighted: there is nothing to be solved"
        raise ConfigError([("map.weights", fact)], where=str(where))
    fem = finite_elements(project, solved=True)
    mapping = build_map(fem, config.map, where)
    field, rows = node_fields(mapping), np.flatnonzero(mapping.through.mapped)
    table = fem.config.model
    out = output if output is not None else fem.source.with_name(_NAME)
    with replacing(out) as temporary:
        source = read_source(
            fem.source, temporary, allow_missing_enddata=table.allow_missing_enddata, units=table.deck_units()
        )
        if os.path.realpath(out) in [os.path.realpath(f) for f in source.sections.files]:
            raise InputError("is a file of the model itself", where=str(out), hint="give it another name")
        written = node_deck(source, mapping.node, rows, field, table.reference_temperature_K)
        temporary.write_bytes(written.text.encode("latin-1"))
        verify_node_deck(temporary, out, source, written, rows, field)
    return NodeDeckSummary(out, mapping.node, len(rows), (*mapping.notes, *written.notes))
