"""areas: the thermal areas of the model before anything is solved, as a table, a CSV and a figure."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from tedm_cli.areas.attributes import area_attributes
from tedm_cli.areas.configured import configured_areas, defines_areas
from tedm_cli.areas.csv_file import area_csv_text
from tedm_cli.areas.definitions import AreaGrids, require_partition
from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.config.model import ModelConfig, load_model
from tedm_cli.config.project import Project
from tedm_cli.config.symmetry_plane import ProjectPlane, project_plane
from tedm_cli.errors import UsageError
from tedm_cli.files.seal import sha256_of
from tedm_cli.files.store import replacing
from tedm_cli.nastran.geometry import ModelGeometry, model_geometry
from tedm_cli.nastran.reading import deck_files, passed_over, read_deck
from tedm_cli.nastran.unit_loads import deck_unit_loads
from tedm_cli.noise.areas import AreaTable

FORMATS = (".svg", ".png")


@dataclass(frozen=True)
class AreaSummary:
    """The areas of a deck.

    source : the deck; origin : what says the areas; notes : what of the deck was not read.
    grids, mass_kg [k]; centroid_m [k,3], mean of the grids.
    """

    source: Path
    origin: str
    found: AreaGrids
    table: AreaTable
    grids: IntArray
    mass_kg: FloatArray
    centroid_m: FloatArray
    structural: int
    total_kg: float
    notes: list[str]
    plane: ProjectPlane

    @property
    def is_partition(self) -> bool:
        return not self.found.left.size

    def require_partition(self) -> None:
        require_partition(self.found, where=str(self.source))

    def as_dict(self) -> dict[str, Any]:
        """What a program needs."""
        t = self.table
        columns = zip(t.name, self.grids, self.mass_kg, self.centroid_m, t.group, t.shield, t.side, strict=True)
        return {
            "deck": str(self.source),
            "defined_by": self.origin,
            "areas": [
                {
                    "name": str(name),
                    "grids": int(grids),
                    "mass_kg": float(mass),
                    "centroid_m": [float(v) for v in centroid],
                    "group": str(group),
                    "shield": str(shield),
                    "side": str(side),
                }
                for name, grids, mass, centroid, group, shield, side in columns
            ],
            "symmetry_plane": {
                "point_m": self.plane.plane.point_m.tolist(),
                "normal": self.plane.plane.normal.tolist(),
                "origin": self.plane.origin,
            },
            "structural_grids": self.structural,
            "model_kg": self.total_kg,
            "is_partition": self.is_partition,
            "grids_in_no_area": self.found.left.tolist(),
            "shared_grids": [
                {"area": o.area, "stay_with": o.earlier, "grids": o.grids.tolist()} for o in self.found.overlaps
            ],
            "notes": [*self.found.notes, *self.notes],
        }


def areas(project: Project, output: Path | None, figure: Path | None) -> AreaSummary:
    """Resolve the areas; write the CSV where they are a partition, and the figure in any case.

    The areas are those of the configuration on the model to be solved, or else those of the unit-load deck.
    """
    if figure is not None and figure.suffix.lower() not in FORMATS:
        raise UsageError(f"--figure {figure}: must end in {' or '.join(FORMATS)}")
    _, config = load_model(project.model)
    defined = defines_areas(config)
    bdf = config.model.bdf if defined else None
    source = project.resolve(bdf if bdf is not None else config.model.deck)
    table = config.model
    model = read_deck(source, allow_missing_enddata=table.allow_missing_enddata, units=table.deck_units())
    geometry = model_geometry(model, deck_files(model, source))
    if defined:
        found = configured_areas(project, config, model, geometry)
        origin = " and ".join(
            [
                *([str(project.resolve(config.model.areas_csv))] if config.model.areas_csv is not None else []),
                *([f"{len(config.areas.define)} definitions of {project.model}"] if config.areas.define else []),
            ]
        )
    else:
        loads = deck_unit_loads(model, geometry, config.model.uniform_label).areas
        found = AreaGrids({a.label: geometry.grid_id[a.rows] for a in loads}, [], np.zeros(0, dtype=np.int64), [], [])
        origin = "its TEMP cards"
    done = _summary(project, config, source, origin, found, geometry, passed_over(model))
    if figure is not None:
        _draw(figure, project, config, done, geometry)
    if output is not None and done.is_partition:
        with replacing(output) as temporary:
            temporary.write_text(area_csv_text(found.areas), encoding="utf-8", newline="\n")
    return done


def _summary(
    project: Project,
    config: ModelConfig,
    source: Path,
    origin: str,
    found: AreaGrids,
    geometry: ModelGeometry,
    notes: list[str],
) -> AreaSummary:
    rows = [np.searchsorted(geometry.grid_id, ids) for ids in found.areas.values()]
    centroid = np.array([geometry.position_m[r].mean(axis=0) for r in rows])
    plane = project_plane(project, config)
    return AreaSummary(
        source=source,
        origin=origin,
        found=found,
        table=area_attributes(list(found.areas), centroid, config.areas, plane.plane, where=str(project.model)),
        grids=np.array([len(r) for r in rows]),
        mass_kg=np.array([geometry.lumped_kg[r].sum() for r in rows]),
        centroid_m=centroid,
        structural=int(geometry.structural.sum()),
        total_kg=geometry.total_kg,
        notes=notes + plane.notes(geometry.position_m[np.concatenate(rows)]),
        plane=plane,
    )


def _draw(path: Path, project: Project, config: ModelConfig, done: AreaSummary, geometry: ModelGeometry) -> None:
    from tedm_cli.figures.model import AreaModel, area_figure
    from tedm_cli.figures.style import png, svg

    label = np.full(len(geometry.grid_id), -1)
    for number, ids in enumerate(done.found.areas.values()):
        label[np.searchsorted(geometry.grid_id, ids)] = number
    signs, test_masses = np.array(list(product((-0.5, 0.5), repeat=3)))[:, ::-1], config.test_masses()
    model = AreaModel(
        position=geometry.position_m,
        card=geometry.elements.type,
        node_offset=geometry.elements.node_offset,
        node_index=geometry.elements.node_index,
        label=label,
        name=[str(n) for n in done.table.name],
        group=[str(g) for g in done.table.group],
        boxes=[t.box_centre_m + (signs * t.side_m) @ t.axes for t in test_masses],
        centre=test_masses[0].position_m if test_masses else geometry.position_m.mean(axis=0),
    )
    title = f"{project.title}: {len(done.grids)} thermal areas of {done.source.name}"
    write = svg if path.suffix.lower() == ".svg" else png
    data = write(area_figure(model, title), title, [f"{done.source.name} {sha256_of(done.source)}"])
    with replacing(path) as temporary:
        temporary.write_bytes(data)
