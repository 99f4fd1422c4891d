"""Areas that fit: connected grids on which the outputs act alike, merged by what each merge does to the outputs."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from field_models import LENGTHS, bar, dense, means, random_points
from sklearn.cluster import KMeans

from tedm_cli.adjoint.connected import joining, pieces, sharing_an_element
from tedm_cli.adjoint.like_grids import like_grids
from tedm_cli.adjoint.merging import Merged, area_covariance, merge_areas
from tedm_cli.adjoint.temperature_field import FieldPoints, area_error
from tedm_cli.arrays import IntArray


def stepped_bar(nx: int = 48) -> tuple[FieldPoints, IntArray, IntArray]:
    """A bar, its pairs of neighbours, and seven uneven lengths of it on which two outputs act evenly, nearly."""
    position, offset, index = bar(nx)
    region = np.searchsorted([2, 5, 11, 13, 30, 33], position[:, 0] / 0.02, side="right")
    draw = np.random.default_rng(5)
    per_volume = draw.normal(size=(2, 7))[:, region] * (1.0 + 1e-3 * draw.normal(size=len(position)))
    volume = np.bincount(index, minlength=len(position)) * 1e-6
    points = FieldPoints(position=position, volume=volume, sensitivity=per_volume * volume)
    return points, sharing_an_element(offset, index, np.zeros(len(position), dtype=np.int64)), region


def connected(label: IntArray, pairs: IntArray) -> bool:
    inside = pairs[label[pairs[:, 0]] == label[pairs[:, 1]]]
    return len(np.unique(pieces(len(label), inside))) == label.max() + 1


def test_neighbours_share_an_element_and_a_part() -> None:
    _, offset, index = bar(3, 2, 2)
    part = np.array([0] * 8 + [1] * 4)
    found = {tuple(pair) for pair in sharing_an_element(offset, index, part).tolist()}
    first = {(a, b) for a in range(8) for b in range(a + 1, 8)}
    assert found == first | {(a, b) for a in range(8, 12) for b in range(a + 1, 12)}
    assert not sharing_an_element(offset, index, np.full(12, -1)).size


def test_pieces_of_an_area_are_joined_where_they_are_near() -> None:
    position = np.array([[0.0, 0, 0], [1, 0, 0], [4, 0, 0], [3, 0, 0], [9, 0, 0]])
    pairs = np.array([[0, 1], [2, 3]])
    assert joining(pairs, position, np.array([0, 0, 0, 0, 1])).tolist() == [[1, 3]]
    assert joining(pairs, position, np.zeros(5, dtype=np.int64)).tolist() == [[1, 3], [2, 4]]
    assert joining(pairs, position, np.arange(5)).shape == (0, 2)


def test_like_grids_are_those_that_the_outputs_feel_alike() -> None:
    points, pairs, region = stepped_bar()
    found = like_grids(points, pairs, 7)
    assert len({(int(a), int(b)) for a, b in zip(found, region, strict=True)}) == 7 == found.max() + 1
    finer = like_grids(points, pairs, 40)
    assert finer.max() + 1 == 40
    assert connected(finer, pairs)


def test_what_nothing_connects_stays_apart() -> None:
    points, pairs, region = stepped_bar()
    apart = pairs[(region[pairs] == region[pairs][:, :1]).all(axis=1)]
    assert like_grids(points, apart, 3).max() + 1 == 7
    assert like_grids(points, apart, len(region)).tolist() == list(range(len(region)))


def test_covariances_by_areas_are_those_of_the_whole_covariance() -> None:
    points, area = random_points(700), np.random.default_rng(2).integers(0, 9, 700)  # more than a block has
    found = area_covariance(points, area, LENGTHS)
    mean, s = means(points, area), points.sensitivity
    for number, length in enumerate(LENGTHS):
        c = dense(points, length)
        assert np.allclose(found.areas[number], mean @ c @ mean.T, rtol=1e-10)
        assert np.allclose(found.outputs[number], s @ c @ mean.T, rtol=1e-9, atol=1e-12)
        assert np.allclose(found.exact[number], np.einsum("rn,nm,rm->r", s, c, s), rtol=1e-10)
    assert np.allclose(found.sensitivity, [np.bincount(area, row) for row in s])


def test_merged_areas_have_the_errors_that_are_told() -> None:
    points, pairs, _ = stepped_bar(16)
    fine = like_grids(points, pairs, 60)
    merged = merge_areas(area_covariance(points, fine, LENGTHS), fine[pairs])
    assert (merged.k, merged.fewest) == (60, 1)
    for count in (60, 59, 24, 5, 1):
        area = merged.areas(count)[fine]
        assert area.max() + 1 == count
        assert connected(area, pairs)
        assert np.allclose(merged.ratio_at(count), area_error(points, area, LENGTHS).ratio, rtol=1e-9)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_each_merge_is_the_one_that_adds_least(seed: int) -> None:
    """Also where the field hardly decorrelates, and what one merge leaves out another one may make up for."""
    points, lengths = random_points(12, seed=seed), (0.3, 3.0)
    pairs = np.array(list(combinations(range(12), 2)))
    merged = merge_areas(area_covariance(points, np.arange(12), lengths), pairs)
    for count in range(11, 2, -1):
        before = merged.areas(count + 1)
        worth = []
        for a, b in combinations(range(count + 1), 2):
            tried = np.unique(np.where(before == b, a, before), return_inverse=True)[1]
            worth.append((area_error(points, tried, lengths).difference ** 4).sum())
        taken = (area_error(points, merged.areas(count), lengths).difference ** 4).sum()
        assert taken == pytest.approx(min(worth), rel=1e-9)


def test_areas_that_fit_beat_areas_of_the_same_count_by_place() -> None:
    points, pairs, _ = stepped_bar()
    fine = like_grids(points, pairs, 60)
    area = merge_areas(area_covariance(points, fine, LENGTHS), fine[pairs]).areas(7)[fine]
    by_place = KMeans(7, n_init=3, random_state=0).fit(points.position, sample_weight=points.volume * 1e6).labels_
    fit, place = (area_error(points, a.astype(np.int64), LENGTHS).difference.max() for a in (area, by_place))
    assert fit < 0.01
    assert place > 0.2


def test_the_fewest_areas_within_an_error_are_those_from_which_on_it_holds() -> None:
    ratio = 1.0 + np.array([0.0, 0.02, 0.06, 0.03, -0.2])[:, None, None]  # of 5, 4, 3, 2, 1 areas
    merged = Merged(5, np.array([[0, 1], [0, 2], [0, 3], [0, 4]]), ratio, np.ones(5, dtype=bool))
    assert merged.error == pytest.approx([0.2, 0.03, 0.06, 0.02, 0.0])
    assert [merged.count_within(e) for e in (0.3, 0.1, 0.05, 0.01)] == [1, 2, 4, 5]
    off = Merged(5, merged.merges, ratio + 0.01, merged.whole)
    assert off.count_within(0.005) is None
