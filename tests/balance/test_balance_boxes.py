"""Boxes as unknowns: parts, shims, images, and what they must keep out of."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import scipy

from tedm_cli.balance.boxes import Box, Image, blocks_of, columns_of, stacked
from tedm_cli.balance.keep_out import Elements, KeepOut, overlapping
from tedm_cli.gravity.compensation import CompensationMass, field_of_compensation_masses
from tedm_cli.gravity.testmass import TestMass
from tedm_cli.symmetry_plane import BASIC_PLANE, SymmetryPlane

TM1, TM2 = (
    TestMass(name=name, position_m=np.array([x, 0.0, 0.0]), side_m=np.full(3, 0.046), mass_kg=1.96)
    for name, x in (("TM1", -0.188), ("TM2", 0.188))
)
MIDWAY = SymmetryPlane(np.zeros(3), np.array([1.0, 0.0, 0.0]))


def box(**changed: Any) -> Box:
    given = {
        "name": "B",
        "centre_m": np.array([-0.14, 0.03, 0.01]),
        "size_m": np.array([0.012, 0.02, 0.03]),
        "axes": scipy.spatial.transform.Rotation.from_rotvec([0.1, -0.2, 0.3]).as_matrix(),
        "density_kg_m3": 18500.0,
        **changed,
    }
    return Box(**given)


def field(blocks: Any, tm: TestMass = TM1) -> Any:
    return field_of_compensation_masses(tm, list(blocks))[0]


def test_parts_fill_their_box() -> None:
    whole = box()
    parts = box(parts=(2, 1, 3)).cut()
    assert [p.name for p in parts] == [f"B_{n}" for n in range(1, 7)]
    assert sum(p.full().mass_kg for p in parts) == pytest.approx(whole.full().mass_kg, rel=1e-12)
    for quantity in ("acceleration", "gamma_lin", "angular_acceleration"):
        one, many = (getattr(field(b), quantity) for b in ([whole.full()], [p.full() for p in parts]))
        np.testing.assert_allclose(many, one, atol=1e-8 * np.abs(one).max())


def test_shims_are_single_blocks_at_their_places_and_a_stack_is_their_sum() -> None:
    """Seven shims have the field of the block that they make; the first lies on the base."""
    stack = box(shim_m=1.6e-3, stack=(0, -1))
    columns = columns_of([stack])
    assert stack.shims == len(columns) == 7
    assert stacked(columns) == [(n, n + 1) for n in range(6)]
    base = stack.centre_m + 0.006 * stack.axes[0]
    np.testing.assert_allclose(stack.base_m, base, atol=1e-15)
    first = columns[0].blocks[0].centre_m
    np.testing.assert_allclose(first, base - 0.8e-3 * stack.axes[0], atol=1e-12)
    units = np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0])
    (made,) = blocks_of([stack], columns, units)
    np.testing.assert_allclose(made.size_m, [4.8e-3, 0.02, 0.03])
    single = [c.blocks[0] for c in columns[:3]]
    assert made.mass_kg == pytest.approx(sum(b.mass_kg for b in single), rel=1e-9)
    for quantity in ("acceleration", "gamma_lin", "angular_acceleration"):
        one, many = (getattr(field(b), quantity) for b in ([made], single))
        np.testing.assert_allclose(many, one, atol=2e-8 * np.abs(one).max())


def test_images_pull_their_test_mass_as_the_block_pulls_the_first() -> None:
    """Mirrored at the plane midway: x and turns about y and z change sign. At y = 0: y, turns about x and z."""
    alike = Image(planes=(MIDWAY,), suffix="_alike", group="IS2")
    both = Image(planes=(MIDWAY, BASIC_PLANE), suffix="_both")
    b = box(images=(Image(group="IS1"), alike, both))
    own, other, far = b.with_images(b.full())
    assert (own.group, other.group, far.group) == ("IS1", "IS2", "")
    assert (own.name, other.name, far.name) == ("B", "B_alike", "B_both")
    f = field([own], TM1)
    for image, flip in ((other, [-1, 1, 1]), (far, [-1, -1, 1])):
        g = field([image], TM2)
        sign = np.array(flip, dtype=float)
        np.testing.assert_allclose(g.acceleration, sign * f.acceleration, atol=1e-8 * np.abs(f.acceleration).max())
        turned = sign * f.angular_acceleration * np.prod(sign)
        np.testing.assert_allclose(g.angular_acceleration, turned, atol=1e-8 * np.abs(turned).max())
        np.testing.assert_allclose(
            g.gamma_lin, np.outer(sign, sign) * f.gamma_lin, atol=1e-8 * np.abs(f.gamma_lin).max()
        )
    straight = box(axes=np.eye(3), images=(Image(), alike, both))
    assert all((image.axes == np.eye(3)).all() for image in straight.with_images(straight.full()))


def test_steps_and_least_masses_are_units() -> None:
    full = box().full().mass_kg
    (column,) = columns_of([box(step_kg=0.02)])
    assert column.whole
    assert column.most == np.floor(full / 0.02)
    assert column.unit_kg == 0.02
    (made,) = blocks_of([box(step_kg=0.02)], [column], np.array([3.0]))
    assert made.mass_kg == pytest.approx(0.06)
    (column,) = columns_of([box(least_kg=0.03, most_kg=0.1)])
    assert column.unit_kg == 0.1
    assert column.least == pytest.approx(0.3)
    assert columns_of([box(step_kg=1.0)]) == []
    assert blocks_of([box()], columns_of([box()]), np.zeros(1)) == []


def test_a_keep_out_is_met_by_what_reaches_into_it() -> None:
    near = KeepOut("TM1", TM1.box_centre_m, TM1.side_m, TM1.axes, clearance_m=3e-3)

    def block(x: float) -> CompensationMass:
        return CompensationMass(name="b", centre_m=[-0.188 + x, 0, 0], size_m=[0.01] * 3, mass_kg=1.0)  # type: ignore[arg-type]

    assert near.is_met_by(block(0.0309))
    assert not near.is_met_by(block(0.031)), "as near as it may be"
    assert not near.is_met_by(block(0.0311))


def test_elements_are_met_by_their_cuboids() -> None:
    """Against points of a grid in a turned block: some lie inside the cuboid of the element, or none."""
    rng = np.random.default_rng(3)
    low = rng.uniform(-0.1, 0.1, (200, 3))
    elements = Elements([f"CHEXA {n}" for n in range(200)], low, low + rng.uniform(0.005, 0.04, (200, 3)))
    turned = scipy.spatial.transform.Rotation.from_rotvec([0.7, 0.4, -0.5]).as_matrix()
    b = CompensationMass(name="b", centre_m=np.zeros(3), size_m=np.array([0.02, 0.06, 0.11]), mass_kg=1.0, axes=turned)
    met = set(elements.met_by(b))
    grid = np.linspace(-0.5, 0.5, 41)
    local = np.stack(np.meshgrid(grid, grid, grid, indexing="ij"), axis=-1).reshape(-1, 3) * b.size_m
    points = local @ turned
    inside = {
        name
        for name, a, z in zip(elements.name, elements.low_m, elements.high_m, strict=True)
        if ((points > a) & (points < z)).all(axis=1).any()
    }
    assert inside <= met
    assert len(met - inside) <= 3, "a corner may lie between the points"
    assert 10 < len(met) < 120


def test_blocks_that_share_space_are_found() -> None:
    flush = [box(parts=(2, 1, 1)).cut()[n].full() for n in (0, 1)]
    assert overlapping(flush) == []
    assert overlapping([*flush, box(name="C").full()]) == [("B_1", "C"), ("B_2", "C")]
