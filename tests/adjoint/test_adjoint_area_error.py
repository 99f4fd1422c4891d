"""How far a model of areas is from the field of temperatures: sums in blocks against the whole, and against draws."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from field_models import LENGTHS, dense, means, random_points

from tedm_cli.adjoint.temperature_field import area_error, field_products

N, K = 700, 9  # more points than a block of the covariance has rows


def sums(rows: np.ndarray, area: np.ndarray) -> np.ndarray:
    return np.array([np.bincount(area, row) for row in rows])


def test_products_in_blocks_are_those_of_the_whole_covariance() -> None:
    points = random_points(N)
    found = field_products(points.position, points.sensitivity, LENGTHS)
    for number, length in enumerate(LENGTHS):
        assert np.allclose(found[number], points.sensitivity @ dense(points, length), rtol=1e-12, atol=1e-12)


def test_error_of_areas_is_that_of_covariances_of_their_means() -> None:
    """S C_A Sᵀ over s C sᵀ, with C_A the covariance of means by volume, as the areas of the chain have them."""
    points, area = random_points(N), np.random.default_rng(2).integers(0, K, N)
    found = area_error(points, area, LENGTHS)
    s, mean = points.sensitivity, means(points, area)
    for number, length in enumerate(LENGTHS):
        c = dense(points, length)
        by_areas = np.einsum("ra,ab,rb->r", sums(s, area), mean @ c @ mean.T, sums(s, area))
        exact = np.einsum("rn,nm,rm->r", s, c, s)
        left = s - sums(s, area) @ mean
        assert np.allclose(found.ratio[number], np.sqrt(by_areas / exact), rtol=1e-10)
        assert np.allclose(
            found.difference[number], np.sqrt(np.einsum("rn,nm,rm->r", left, c, left) / exact), rtol=1e-9
        )
        share = sums(left * (left @ c), area)
        assert np.allclose(found.share[number], share / share.sum(axis=1, keepdims=True), atol=1e-9)


def test_a_field_without_structure_is_told_by_any_areas() -> None:
    points, area = random_points(N), np.random.default_rng(2).integers(0, K, N)
    ratio = area_error(points, area, (0.02, 1e9)).ratio
    assert np.allclose(ratio[1], 1.0, atol=1e-7)
    assert np.all(np.abs(ratio[0] - 1.0) > 0.1)


def test_one_point_per_area_is_exact() -> None:
    points = random_points(N)
    found = area_error(points, np.random.default_rng(2).permutation(N), LENGTHS)
    assert np.allclose(found.ratio, 1.0, rtol=1e-12)
    assert np.all(found.difference < 1e-7)


def test_areas_of_even_sensitivity_per_volume_are_exact_wherever_they_are() -> None:
    """Not their size and form count, but what differs in them."""
    points, area = random_points(N), np.random.default_rng(2).integers(0, K, N)
    per_volume = np.random.default_rng(3).normal(size=(2, K))
    even = replace(points, sensitivity=per_volume[:, area] * points.volume)
    assert np.allclose(area_error(even, area, LENGTHS).ratio, 1.0, rtol=1e-10)


def test_drawn_fields_have_these_deviations() -> None:
    points, area = random_points(80), np.random.default_rng(2).integers(0, 5, 80)
    draws, draw = 20_000, np.random.default_rng(4)
    found = area_error(points, area, LENGTHS)
    for number, length in enumerate(LENGTHS):
        field = np.linalg.cholesky(dense(points, length)) @ draw.normal(size=(80, draws))
        exact = points.sensitivity @ field
        model = sums(points.sensitivity, area) @ (means(points, area) @ field)
        spread = 5.0 / np.sqrt(draws)  # five standard deviations of the ratio, where the two were independent
        assert model.std(axis=1) / exact.std(axis=1) == pytest.approx(found.ratio[number], rel=spread)
        assert (exact - model).std(axis=1) / exact.std(axis=1) == pytest.approx(found.difference[number], rel=spread)
