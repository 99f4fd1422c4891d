"""map-temperatures: temperatures of grids from those of thermal nodes, and how good the field is."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.config.project import Project
from tedm_cli.config.thermal.file import load_thermal
from tedm_cli.errors import ConfigError, InputError, UsageError
from tedm_cli.files.build_folder import provenance
from tedm_cli.mapping.averages import NONE
from tedm_cli.mapping.node_map import ConductedMap
from tedm_cli.mapping.quality import Quality, quality
from tedm_cli.stages.area_drawing import require_format
from tedm_cli.stages.common import known_name
from tedm_cli.stages.thermal.map_build import Mapping, build_map
from tedm_cli.stages.thermal.map_case import PATTERN_UNIT, OfCase, case_pattern
from tedm_cli.stages.thermal.map_model import finite_elements
from tedm_cli.stages.thermal.map_output import FORMATS, MappedField, write_field
from tedm_cli.stages.thermal.map_tau import read_given


@dataclass(frozen=True, eq=False)
class MappedSummary:
    """What was mapped, and how well.

    paths : files written. sets : [m] names. mapping : with its n nodes. found : None with weights.
    elements, volume : [n], number of elements and m³ of each node; zeros with weights. sid : of each set in a .bdf.
    """

    paths: list[Path]
    sets: list[str]
    mapping: Mapping
    field: FloatArray
    found: Quality | None
    elements: IntArray
    volume: FloatArray
    sid: list[int]
    notes: list[str]

    @property
    def worst(self) -> int:
        """The set whose field changes most across an element."""
        return 0 if self.found is None else int(self.found.jump.argmax())

    def element_id(self, number: int) -> int | None:
        """Id of the element across which a set's field changes most."""
        if self.found is None or self.found.element[number] == NONE:
            return None
        return int(self.mapping.fem.geometry.elements.id[self.found.element[number]])

    def as_dict(self) -> dict[str, Any]:
        """What a program needs."""
        m, q, a = self.mapping, self.found, self.mapping.association
        conducted = m.through if isinstance(m.through, ConductedMap) else None
        return {
            "model": str(m.fem.source),
            "files": [str(path) for path in self.paths],
            "grids": int(m.through.mapped.sum()),
            "solver": None if conducted is None else conducted.solver,
            "nodes": [
                {"name": name, "elements": int(count), "volume_m3": float(volume)}
                for name, count, volume in zip(m.node, self.elements, self.volume, strict=True)
            ],
            "sets": [
                {
                    "name": name,
                    "sid": self.sid[i] if self.sid else None,
                    "least_K": float(np.nanmin(self.field[:, i])),
                    "largest_K": float(np.nanmax(self.field[:, i])),
                    "average_error_K": None if q is None else float(q.kept[i]),
                    "largest_change_across_an_element_K": None if q is None else float(q.jump[i]),
                    "in_element": self.element_id(i),
                    "step_of_temperature_cards_K": None if q is None else float(q.step[i]),
                }
                for i, name in enumerate(self.sets)
            ],
            "nearest": [
                {"node": r.node, "elements": r.elements, "mean_m": r.mean_m, "largest_m": r.largest_m}
                for r in (a.nearest if a else [])
            ],
            "elements_beyond_nearest_within": a.beyond if a else 0,
            "nodes_in_several_parts": [] if conducted is None else [m.node[i] for i in conducted.several.tolist()],
            "grids_left_out": m.left_out.tolist(),
            "unmapped": [{"areas": areas, "elements": ids.tolist()} for areas, ids in m.unmapped],
            "notes": self.notes,
        }


def map_temperatures(
    project: Project, given: Path | OfCase, output: Path | None, figure: Path | None, shown: str | None
) -> MappedSummary:
    """Map sets of temperatures, and write what was asked for.

    Parameters
    ----------
    given : a CSV of sets, or a case of the thermal network, of which they are what `case_pattern` tells.
    shown : the set that the figure shows; the first.

    Raises
    ------
    UsageError : a name of a file that says no format, a set that there is not.
    ConfigError : a project without a map. InputError, PhysicsError : what `build_map`, `read_given` and `case_pattern`
        refuse.
    """
    require_format(figure)
    if output is not None and output.suffix.lower() not in FORMATS:
        raise UsageError(f"-o {output}: must end in {', '.join(FORMATS[:-1])} or {FORMATS[-1]}")
    where = project.required_thermal()
    file, config = load_thermal(where)
    if config.map is None:
        raise ConfigError([("map", "is missing: nothing says where the thermal nodes are")], where=str(where))
    fem = finite_elements(project)
    mapping = build_map(fem, config.map, where)
    _refuse_own_temperatures(mapping)
    if isinstance(given, OfCase):
        pattern = case_pattern(project, given)
        sets, more, said, unit = pattern.of(mapping.node), pattern.inputs, [pattern.words], PATTERN_UNIT
    else:
        sets, more, said, unit = read_given(given, mapping.node), [given], [], "K"
    if shown is not None:
        known_name("set", shown, sets.name)
    field = mapping.through.temperatures(sets.tau)
    elements, volume, found = np.zeros(len(mapping.node), dtype=np.int64), np.zeros(len(mapping.node)), None
    if mapping.association is not None and isinstance(mapping.through, ConductedMap):
        place, of = mapping.association.place_node, fem.volumes
        taken = place != NONE
        pairs = np.unique(np.column_stack([place, of.element])[taken], axis=0)
        elements = np.bincount(pairs[:, 0], minlength=len(mapping.node))
        volume = np.bincount(place[taken], of.volume[taken], len(mapping.node)).astype(np.float64)
        found = quality(mapping.through, of, place, sets.tau, field)
    mapped = MappedField(mapping, sets.name, sets.tau, field, unit)
    inputs = [*more, *fem.files, *(project.beside(where, name) for name in config.map.file_names())]
    paths, sid, notes = write_field(output, mapped, lambda: provenance([file, fem.config_file], inputs))
    if figure is not None:
        from tedm_cli.stages.thermal.map_figure import draw_field

        draw_field(figure, project, mapped, sets.name.index(shown) if shown is not None else 0)
        paths = [*paths, figure]
    return MappedSummary(
        paths, sets.name, mapping, field, found, elements, volume, sid, [*said, *mapping.notes, *notes]
    )


def _refuse_own_temperatures(mapping: Mapping) -> None:
    """Areas whose elements have temperatures of their own have no field over grids."""
    if mapping.weights is None:
        return
    weighted = zip(mapping.fem.areas.items(), mapping.weights, strict=True)
    bare = [name for (name, load), row in weighted if load.element_id.size and row.any()]
    if bare:
        raise InputError(
            f"areas that warm elements and not grids: {', '.join(bare[:8])}",
            where=str(mapping.fem.source),
            hint="the temperatures of grids do not say theirs: map by elements, nodes or areas instead of weights",
        )
