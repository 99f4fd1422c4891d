"""Cross-sections by name: areas and moments by integration, torsion from the theory, shear factors from tables."""

from __future__ import annotations

import numpy as np
import pytest

from tedm_cli.nastran.structure.sections import SECTIONS


def rectangles(*parts: tuple[float, float, float]) -> tuple[float, float, float]:
    """Area, ∫ y² dA and ∫ z² dA of centred rectangles (width along z, height along y, sign) by Gauss's rule."""
    node, weight = np.polynomial.legendre.leggauss(3)
    sums = np.zeros(3)
    for width, height, sign in parts:
        z, y = np.meshgrid(width / 2 * node, height / 2 * node)
        area = sign * width * height / 4 * np.outer(weight, weight)
        sums += [area.sum(), (area * y**2).sum(), (area * z**2).sum()]
    return tuple(sums)


def ring(outer: float, inner: float) -> tuple[float, float]:
    """Area and ∫ y² dA between two radii, in polar coordinates."""
    node, weight = np.polynomial.legendre.leggauss(4)
    r, dr = (outer + inner + (outer - inner) * node) / 2, (outer - inner) / 2 * weight
    return 2 * np.pi * (r * dr).sum(), np.pi * (r**3 * dr).sum()


def torsion_of_rectangle(long: float, short: float) -> float:
    """Saint-Venant's series (Timoshenko & Goodier, Theory of Elasticity, section 109)."""
    n = np.arange(1, 400, 2)
    tail = (np.tanh(n * np.pi * long / (2 * short)) / n**5).sum()
    return long * short**3 / 3 * (1 - 192 / np.pi**5 * short / long * tail)


@pytest.mark.parametrize(("width", "height"), [(0.03, 0.03), (0.02, 0.03), (0.045, 0.03), (0.01, 0.1), (0.2, 0.002)])
def test_fem_bar_section(width: float, height: float) -> None:
    """Roark's formula for torsion is within half a percent of the series."""
    area, i1, i2, i12, torsion, k1, k2 = SECTIONS["BAR"](width, height)
    assert (area, i1, i2) == pytest.approx(rectangles((width, height, 1)), rel=1e-12)
    assert torsion == pytest.approx(torsion_of_rectangle(max(width, height), min(width, height)), rel=5e-3)
    assert (i12, k1, k2) == (0.0, 5 / 6, 5 / 6)  # Cowper 1966, Poisson's ratio 0


@pytest.mark.parametrize(
    ("name", "dimensions", "outer", "inner", "shear"),
    [
        ("ROD", (0.01,), 0.01, 0.0, 0.9),
        ("TUBE", (0.01, 0.009), 0.01, 0.009, 0.5),
        ("TUBE2", (0.01, 0.001), 0.01, 0.009, 0.5),
    ],
)
def test_fem_round_sections(name: str, dimensions: tuple[float, ...], outer: float, inner: float, shear: float) -> None:
    area, i1, i2, i12, torsion, k1, k2 = SECTIONS[name](*dimensions)
    assert (area, i1) == pytest.approx(ring(outer, inner), rel=1e-12)
    assert (i2, torsion, i12) == pytest.approx((i1, 2 * i1, 0.0), rel=1e-12)  # polar: the sum of both
    assert (k1, k2) == (shear, shear)


def test_fem_box_section() -> None:
    """DIM1 and DIM2 are width and height, DIM3 the thickness of the walls above and below, DIM4 that of the sides."""
    width, height, flange, web = 0.04, 0.03, 0.002, 0.003
    area, i1, i2, i12, torsion, k1, k2 = SECTIONS["BOX"](width, height, flange, web)
    hollow = (width - 2 * web, height - 2 * flange, -1)
    assert (area, i1, i2) == pytest.approx(rectangles((width, height, 1), hollow), rel=1e-12)
    # Bredt: 4 area² over the integral of ds / t along the middle line
    middle = (width - web) * (height - flange)
    assert torsion == pytest.approx(
        4 * middle**2 / (2 * (width - web) / flange + 2 * (height - flange) / web), rel=1e-12
    )
    # shear along y is carried by the sides, along z by the walls above and below
    assert (k1 * area, k2 * area, i12) == pytest.approx((2 * web * height, 2 * flange * width, 0.0), rel=1e-12)
