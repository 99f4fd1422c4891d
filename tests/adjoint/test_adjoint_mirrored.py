"""Areas of which a case asks for mirror images: merged on both sides at once."""

from __future__ import annotations

import numpy as np
import pytest
from field_models import LENGTHS, bar

from tedm_cli.adjoint.connected import sharing_an_element
from tedm_cli.adjoint.merging import area_covariance, merge_areas
from tedm_cli.adjoint.mirrored import images, mirrored_clusters
from tedm_cli.adjoint.temperature_field import FieldPoints, area_error
from tedm_cli.arrays import IntArray
from tedm_cli.symmetry_plane import SymmetryPlane

N = 17 * 9  # a bar of this many grids about its middle, beside one without images


def two_bars() -> tuple[FieldPoints, IntArray, SymmetryPlane, IntArray]:
    """Points, their pairs, the plane across the first bar, and images of its points; the outputs have no symmetry."""
    position, offset, index = bar(17)
    both = np.concatenate([position, position + np.array([0.5, 0.3, 0.0])])
    offsets = np.concatenate([offset, offset[1:] + offset[-1]])
    pairs = sharing_an_element(offsets, np.concatenate([index, index + N]), np.repeat([0, 1], N))
    draw = np.random.default_rng(7)
    points = FieldPoints(
        position=both, volume=draw.uniform(0.5, 2.0, 2 * N) * 1e-6, sensitivity=draw.normal(size=(2, 2 * N))
    )
    plane = SymmetryPlane(np.array([0.16, 0.0, 0.0]), np.array([1.0, 0.0, 0.0]))
    image = images(both, plane, np.arange(2 * N) < N)
    assert image is not None
    return points, pairs, plane, image


def test_images_are_found_where_they_are() -> None:
    points, _, plane, image = two_bars()
    assert np.allclose(points.position[image[:N]], plane.image(points.position[:N]))
    assert (image[N:] == -1).all()
    bent = points.position + np.where(np.arange(2 * N) == 3, 5e-3, 0.0)[:, None]
    assert images(bent, plane, np.arange(2 * N) < N) is None
    assert images(points.position, plane, np.arange(2 * N) >= N) is None


def test_areas_with_images_have_them_at_every_count() -> None:
    points, pairs, plane, image = two_bars()
    fine, twin, merging = mirrored_clusters(points, pairs, image, plane, 60)
    assert 50 <= len(twin) <= 75
    assert np.array_equal(twin[fine[:N]], fine[image[:N]])
    assert (twin[np.unique(fine[N:])] == -1).all()
    new = np.random.default_rng(3).permutation(len(twin))  # whatever the numbers are
    twin[new], fine, merging = np.where(twin >= 0, new[twin], -1), new[fine], new[merging]
    merged = merge_areas(area_covariance(points, fine, LENGTHS), merging, twin)
    assert merged.fewest == 2
    alone = 0
    for count in range(2, merged.k + 1):
        if merged.nearest(count) != count:
            alone += 1
            continue
        area = merged.areas(count)[fine]
        assert area.max() + 1 == count
        there = {frozenset(np.flatnonzero(area[:N] == a).tolist()) for a in np.unique(area[:N])}
        assert {frozenset(image[list(members)].tolist()) for members in there} == there
    assert alone < 20  # counts at which it is better, or all that is left, to merge in the bar with images
    for count in (merged.k - 1, 40, 21, 20, 5):
        wanted = area_error(points, merged.areas(count)[fine], LENGTHS).ratio
        assert merged.ratio_at(count) == pytest.approx(wanted, rel=1e-9)
