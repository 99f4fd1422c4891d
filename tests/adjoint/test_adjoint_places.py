"""Places: connected elements of one area and one sign; and the scale of a map."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from tedm_cli.adjoint.places import density_bound, places_of


def chain_of(
    value: list[float], area: list[int], links: list[tuple[int, int]] | None = None
) -> list[tuple[set[int], float]]:
    """Places of elements in a row, each sharing a grid with the next (or by the grids in `links`)."""
    n = len(value)
    node = np.array(links or [(e, e + 1) for e in range(n)]).reshape(-1)
    centre = np.column_stack([np.arange(n), np.zeros(n), np.ones(n)]).astype(np.float64)
    found = places_of(np.array(value), np.full(n, 2.0), np.array(area), centre, np.arange(n + 1) * 2, node)
    return [(set(p.elements.tolist()), p.value) for p in found]


def test_area_sign_and_gaps_divide() -> None:
    assert chain_of([1.0, 2.0, -5.0, -1.0, 4.0, 0.5], [0, 0, 0, 1, 1, 1]) == [
        ({2}, -5.0),
        ({4, 5}, 4.5),
        ({0, 1}, 3.0),
        ({3}, -1.0),
    ]
    assert chain_of([1.0, 2.0], [0, 0], [(0, 1), (2, 3)]) == [({1}, 2.0), ({0}, 1.0)]
    assert chain_of([1.0, 2.0], [0, 0], [(0, 1), (3, 1)]) == [({0, 1}, 3.0)]


def test_what_does_not_act_is_no_place_and_no_bridge() -> None:
    assert chain_of([1.0, 0.0, 1.5], [-1, -1, -1]) == [({2}, 1.5), ({0}, 1.0)]
    assert chain_of([0.0, 0.0], [0, 0]) == []


def test_centre_is_where_it_acts_most() -> None:
    value, centre = np.array([3.0, 1.0, -4.0]), np.array([[0.0, 0, 0], [1.0, 2, 0], [5.0, 5, 5]])
    first, second = places_of(
        value,
        np.array([1.0, 2.0, 4.0]),
        np.array([7, 7, 7]),
        centre,
        np.array([0, 2, 4, 6]),
        np.array([0, 1, 1, 2, 8, 9]),
    )
    assert (first.share, second.share) == (0.5, 0.5)
    np.testing.assert_allclose(first.position, [0.25, 0.5, 0.0])
    np.testing.assert_allclose(second.position, [5.0, 5.0, 5.0])
    assert (first.area, first.volume, second.volume) == (7, 3.0, 4.0)


@given(arrays(float, 30, elements=st.floats(-1, 1).map(lambda x: round(x, 6))), st.integers(0, 99))
def test_places_are_all_that_acts(value: np.ndarray, seed: int) -> None:
    rng = np.random.default_rng(seed)
    found = places_of(
        value,
        np.ones(30),
        rng.integers(-1, 3, 30),
        rng.normal(size=(30, 3)),
        3 * np.arange(31),
        rng.integers(0, 40, 90),
    )
    members = np.concatenate([np.zeros(0, dtype=int), *(p.elements for p in found)])
    np.testing.assert_array_equal(np.sort(members), np.flatnonzero(value))
    assert sum(p.value for p in found) == pytest.approx(value.sum(), abs=1e-12)
    assert not found or sum(p.share for p in found) == pytest.approx(1.0)
    assert [p.share for p in found] == sorted((p.share for p in found), reverse=True)


def test_no_single_element_sets_the_scale() -> None:
    """An element of a hundred times the density and a thousandth of the sizes is beyond it; one of a tenth is not."""
    volume = np.ones(101)
    value = np.linspace(1.0, 2.0, 101)
    volume[0], value[0] = 1e-5, 1e-3 * value[1:].sum()
    assert density_bound(value, volume) < 2.0
    volume[0], value[0] = 1e-3, -0.1 * value[1:].sum()
    assert density_bound(value, volume) == pytest.approx(-value[0] / volume[0])
    beyond = np.abs(value) / volume > density_bound(value, volume)
    assert np.abs(value[beyond]).sum() <= 0.05 * np.abs(value).sum()


def test_scale_of_nothing() -> None:
    assert density_bound(np.zeros(3), np.ones(3)) == 0.0
    assert density_bound(np.ones(2), np.zeros(2)) == 0.0
