"""The figure of a mapped field on the model."""

from __future__ import annotations

from itertools import product
from pathlib import Path

import numpy as np

from tedm_cli.config.project import Project
from tedm_cli.stages.area_drawing import write_figure
from tedm_cli.stages.thermal.map_output import MappedField


def draw_field(path: Path, project: Project, mapped: MappedField, number: int) -> None:
    """Draw one set of temperatures."""
    from tedm_cli.figures.model.adjoint_map import MapViews
    from tedm_cli.figures.model.temperature_map import temperature_figure
    from tedm_cli.figures.model.views import Mesh

    fem = mapped.mapping.fem
    e = fem.geometry.elements
    signs, test_masses = np.array(list(product((-0.5, 0.5), repeat=3)))[:, ::-1], fem.config.test_masses()
    mesh = Mesh(
        position=fem.geometry.position_m,
        card=e.type,
        node_offset=e.node_offset,
        node_index=e.node_index,
        boxes=[t.box_centre_m + (signs * t.side_m) @ t.axes for t in test_masses],
        centre=test_masses[0].position_m if test_masses else fem.geometry.position_m.mean(axis=0),
    )
    title = f"{project.title}: temperatures {mapped.name[number]} of {fem.source.name}"
    figure = temperature_figure(MapViews(mesh), mapped.field[:, number], title, "above the reference", mapped.unit)
    write_figure(path, figure, title, fem.source)
