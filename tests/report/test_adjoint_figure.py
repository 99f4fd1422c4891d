"""The figure of where a kelvin acts: colours of elements by sign and size, legible, whatever the mesh."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
from figure_texts import drawn
from matplotlib.figure import Figure
from test_figures_legible import faults

from tedm_cli.figures.model.adjoint_map import MapViews, adjoint_figure
from tedm_cli.figures.model.views import Mesh

sys.path.append(str(Path(__file__).parents[1] / "fem"))

from fem_models import solid_mesh

TITLE = "Where a kelvin acts: read-out of x, test mass 2, sets A and B"


def views(size: tuple[float, float, float]) -> MapViews:
    """Two bricks side by side along x, and a box in the first."""
    position, cells = solid_mesh("CHEXA", 8, (2, 1, 1), size)
    box = 0.2 * np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]) * size
    return MapViews(
        Mesh(
            position=position,
            card=["CHEXA", "CHEXA"],
            node_offset=np.array([0, 8, 16]),
            node_index=cells.reshape(-1),
            boxes=[box],
            centre=0.6 * np.array(size),  # what is cut away is in front of it
        )
    )


def figure(density: list[float], bound: float, size: tuple[float, float, float] = (0.4, 0.3, 0.2)) -> Figure:
    return drawn(adjoint_figure(views(size), np.array(density), bound, TITLE, "sensitivity per volume (m/K per m³)"))


def halves(found: Figure) -> tuple[np.ndarray, np.ndarray]:
    """Mean colours of the left and the right half of what is not white in the view from outside."""
    image = next(np.asarray(a.images[0].get_array()) for a in found.axes if a.images)
    row, column = np.nonzero((image < 0.99).any(axis=2))
    left = column < np.quantile(column, 0.15)
    right = column > np.quantile(column, 0.85)
    return image[row[left], column[left]].mean(axis=0), image[row[right], column[right]].mean(axis=0)


def test_signs_have_their_colours_and_sizes_their_depth() -> None:
    left, right = halves(figure([1e-3, -1e-3], 1e-3))
    assert left[0] > left[2] + 0.1, "positive is vermilion"
    assert right[2] > right[0] + 0.1, "negative is blue"
    weak, _ = halves(figure([3e-6, -1e-3], 1e-3))
    assert weak.mean() > left.mean() + 0.2
    beyond, _ = halves(figure([1.0, -1e-3], 1e-3))
    np.testing.assert_allclose(beyond, left, atol=1e-12)


def test_without_volume_it_is_grey() -> None:
    grey, _ = halves(figure([np.nan, -1e-3], 1e-3))
    nothing, _ = halves(figure([0.0, -1e-3], 1e-3))
    assert np.ptp(grey) < 0.02
    assert grey.mean() < nothing.mean() - 0.15
    said = [t.get_text() for t in figure([np.nan, 1.0], 1.0).texts]
    assert any("grey: no volume" in t for t in said)


@pytest.mark.parametrize(
    ("size", "bound"),
    [((0.4, 0.3, 0.2), 0.0), ((5.0, 0.1, 0.1), 1e-3), ((0.1, 2.0, 3.0), 3.3e-12), ((1e-3, 1e-3, 9e-3), 9e9)],
)
def test_it_is_legible(size: tuple[float, float, float], bound: float) -> None:
    assert faults(figure([bound, -0.3 * bound], bound, size)) == []
