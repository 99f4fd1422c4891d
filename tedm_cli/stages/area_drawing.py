"""The figure of a model coloured by thermal area, which several commands write."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tedm_cli.areas.places import corner_areas, element_owners
from tedm_cli.config.model.file import ModelConfig
from tedm_cli.config.project import Project
from tedm_cli.errors import UsageError
from tedm_cli.files.seal import sha256_of
from tedm_cli.files.store import replacing
from tedm_cli.nastran.geometry import ModelGeometry
from tedm_cli.nastran.loads.area_loads import AreaLoad
from tedm_cli.nastran.membership import membership

if TYPE_CHECKING:
    from tedm_cli.figures.model.gradient_arrows import GradientArrows

FORMATS = (".svg", ".png")


def require_format(figure: Path | None, option: str = "--figure") -> None:
    """Refuse a name of the figure that says neither of the two formats."""
    if figure is not None and figure.suffix.lower() not in FORMATS:
        raise UsageError(f"{option} {figure}: must end in {' or '.join(FORMATS)}")


def write_figure(path: Path, figure: Any, title: str, source: Path) -> None:
    """Write a figure in the format that the name says, with the sum of the file that it is of."""
    from tedm_cli.figures.drawing.style import png, svg

    write = svg if path.suffix.lower() == ".svg" else png
    data = write(figure, title, [f"{source.name} {sha256_of(source)}"])
    with replacing(path) as temporary:
        temporary.write_bytes(data)


def draw_areas(
    path: Path,
    project: Project,
    config: ModelConfig,
    source: Path,
    model: Any,
    geometry: ModelGeometry,
    loads: Mapping[str, AreaLoad],
    groups: Sequence[str],
    what: str,
) -> None:
    """Draw the model of the deck `source` coloured by area, gradients as arrows.

    Parameters
    ----------
    model, geometry : as read from it. loads : [k], by name. groups : [k]. what : the areas, in words.
    """
    from tedm_cli.figures.model.areas import AreaModel, area_figure

    means = {name: load for name, load in loads.items() if load.gradient is None}
    shown = list(means.values())
    signs, test_masses = np.array(list(product((-0.5, 0.5), repeat=3)))[:, ::-1], config.test_masses()
    drawn = AreaModel(
        position=geometry.position_m,
        card=geometry.elements.type,
        node_offset=geometry.elements.node_offset,
        node_index=geometry.elements.node_index,
        label=corner_areas(geometry, shown, element_owners(geometry, shown)),
        name=list(means),
        group=[group for group, load in zip(groups, loads.values(), strict=True) if load.gradient is None],
        boxes=[t.box_centre_m + (signs * t.side_m) @ t.axes for t in test_masses],
        gradient=_arrows(model, geometry, loads),
        centre=test_masses[0].position_m if test_masses else geometry.position_m.mean(axis=0),
    )
    title = f"{project.title}: {len(loads)} {what} of {source.name}"
    write_figure(path, area_figure(drawn, title), title, source)


def _arrows(model: Any, geometry: ModelGeometry, loads: Mapping[str, AreaLoad]) -> list[GradientArrows]:
    """The areas under a gradient, as they are drawn."""
    from tedm_cli.figures.model.gradient_arrows import GradientArrows

    under = {name: (load.element_id, load.gradient) for name, load in loads.items() if load.gradient is not None}
    if not under:
        return []
    axes = membership(model, geometry, positions=False, axes=True).axes
    found = []
    for name, (ids, gradient) in under.items():
        rows = np.searchsorted(geometry.elements.id, ids)
        found.append(GradientArrows(name, geometry.centres(rows), (gradient[:, :, None] * axes[rows]).sum(axis=1)))
    return found
