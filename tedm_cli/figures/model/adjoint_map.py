"""Figures of a model coloured by what a kelvin does to an output, per volume: from outside, and cut open."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

from tedm_cli.arrays import FloatArray
from tedm_cli.figures.drawing.cells import signed_bar, signed_colours
from tedm_cli.figures.drawing.spec import PAGE_WIDTH
from tedm_cli.figures.drawing.style import SMALL, heading, heading_lines, style
from tedm_cli.figures.model.views import FRONT, ISOMETRIC, PLAN, Mesh, Seen, View, seen_in, show

_NO_VOLUME = "#B8B8B8"
LEFT, _RIGHT, _GAP, _ACROSS = 0.15, 0.1, 0.65, 0.75  # inches
SCALE_ROOM, _FOOT = 0.8, 0.42


@dataclass(frozen=True, eq=False)
class _Panel:
    view: View
    cut: bool
    place: tuple[float, float, float, float]  # left, bottom, width, height; inches, without what is above


class MapViews:
    """The views of a mesh that all maps of it share: what they show is found once, and coloured for each output."""

    def __init__(self, mesh: Mesh) -> None:
        self.mesh = mesh
        extent = np.maximum(np.ptp(mesh.position, axis=0), 0.3 * np.ptp(mesh.position, axis=0).max())
        wide = (PAGE_WIDTH - LEFT - _RIGHT - _ACROSS) / 2
        scale = wide / extent[0]
        front, plan = min(3.2, scale * extent[2]), min(3.2, scale * extent[1])
        right, half = LEFT + wide + _ACROSS, (front + plan) / 2
        self._panels = (
            _Panel(ISOMETRIC, False, (LEFT, _FOOT + half + _GAP, wide, half)),
            _Panel(PLAN, True, (right, _FOOT + front + _GAP, wide, plan)),
            _Panel(ISOMETRIC, True, (LEFT, _FOOT, wide, half)),
            _Panel(FRONT, True, (right, _FOOT, wide, front)),
        )
        self.height = _FOOT + front + _GAP + plan + 0.25
        self._seen: list[Seen] = []

    @property
    def panels(self) -> list[tuple[Seen, tuple[float, float, float, float]]]:
        """What is seen in each panel, labels being rows of elements, and where the panel is."""
        if not self._seen:
            mesh = self.mesh
            label = np.repeat(np.arange(len(mesh.card)), np.diff(mesh.node_offset))
            self._seen = [
                seen_in(mesh, label, len(mesh.card), p.view, np.array(p.place[2:]), cut=p.cut) for p in self._panels
            ]
        return [(seen, panel.place) for seen, panel in zip(self._seen, self._panels, strict=True)]


def adjoint_figure(views: MapViews, density: FloatArray, bound: float, title: str, unit: str) -> Figure:
    """The model coloured by sensitivity per volume.

    Parameters
    ----------
    density : [E] of the elements of the mesh, in `unit`; NaN where there is none. bound : at the ends of the scale.
    """
    with style():
        more = "below a thousandth of the scale's ends colours fade to white; dashed: test masses"
        if np.isnan(density).any():
            more += "; grey: no volume"
        _, _, head = heading_lines(title, more, PAGE_WIDTH)
        height = head + SCALE_ROOM + views.height
        figure = Figure(figsize=(PAGE_WIDTH, height), dpi=150)
        heading(figure, title, more=more)
        colours = signed_colours(np.array([bound]))
        signed_bar(figure, colours, (LEFT + 0.3, height - head - 0.55, 4.6), unit)
        rgb = np.asarray(colours.table(np.asarray(colours.norm(np.clip(np.nan_to_num(density), -bound, bound)))))
        table = np.concatenate([rgb[:, :3], [to_rgb(_NO_VOLUME)]])
        table[:-1][np.isnan(density)] = to_rgb(_NO_VOLUME)
        for seen, (left, bottom, wide, tall) in views.panels:
            axes = figure.add_axes((left / PAGE_WIDTH, bottom / height, wide / PAGE_WIDTH, tall / height))
            show(axes, views.mesh, seen, table, borders=False, sizes=(SMALL, SMALL))
        return figure
