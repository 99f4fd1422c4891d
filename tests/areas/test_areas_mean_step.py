"""The mean step of an area's own elements: against integrals by hand, and what it says of a strut of one bar."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tedm_cli.areas.mean_step import MeanStep, mean_steps
from tedm_cli.cli.printing.areas import mean_step_lines
from tedm_cli.nastran.geometry import ModelGeometry, model_geometry
from tedm_cli.nastran.loads.area_loads import AreaLoad, none
from tedm_cli.nastran.node_volumes import node_volumes
from tedm_cli.nastran.reading import deck_files, read_deck

HEAD = "SOL 101\nCEND\nBEGIN BULK\nMAT1,1,7.+10,,.33,2700.,2.3-5\n"


def geometry_of(path: Path, bulk: str) -> ModelGeometry:
    path.write_text(HEAD + bulk + "ENDDATA\n")
    model = read_deck(path)
    return model_geometry(model, deck_files(model, path))


def grids(*places: tuple[float, float, float]) -> str:
    return "".join(f"GRID,{i},,{float(x)},{float(y)},{float(z)}\n" for i, (x, y, z) in enumerate(places, start=1))


@pytest.fixture(scope="module")
def strut(tmp_path_factory: pytest.TempPathFactory) -> ModelGeometry:
    """Plates 1 x 1 m at z = 0 and z = 1, of four quads each, and one bar from corner to corner."""
    places = [(x, y, z) for z in (0.0, 1.0) for y in (0.0, 0.5, 1.0) for x in (0.0, 0.5, 1.0)]
    bulk = grids(*places) + "PSHELL,1,1,.01\nPBAR,2,1,1.-4,1.-9,1.-9,2.-9\nCBAR,100,2,5,14,1.,0.,0.\n"
    for plate in (0, 1):
        for k, a in enumerate((1, 2, 4, 5)):
            n = a + 9 * plate
            bulk += f"CQUAD4,{10 * plate + k + 1},1,{n},{n + 1},{n + 4},{n + 3}\n"
    return geometry_of(tmp_path_factory.mktemp("strut") / "strut.bdf", bulk)


def area(*ids: int) -> AreaLoad:
    return AreaLoad(np.array(ids, dtype=np.int64), none(), none())


def test_one_bar_that_lost_an_end_gets_half_its_step(strut: ModelGeometry) -> None:
    """Both plates keep all; a bar that kept one of its two grids gets half, one that lost none gets all."""
    lower, upper = area(*range(1, 10)), area(*(i for i in range(10, 19) if i != 14))
    found = mean_steps(strut, {"LOWER": lower, "UPPER": upper, "STRUT": area(14)}, {"STRUT": np.array([100])})
    assert [(s.area, s.elements.tolist()) for s in found] == [
        ("LOWER", [1, 2, 3, 4, 100]),
        ("UPPER", [11, 12, 13, 14]),
        ("STRUT", [100]),
    ]
    # 0.01 m3 of a plate wholly, 1e-4 m3 of the bar by half and counted by half; a corner of four in each quad is lost
    assert found[0].share == pytest.approx((0.01 + 0.25e-4) / (0.01 + 0.5e-4), rel=1e-12)
    assert found[1].share == pytest.approx(0.75, rel=1e-12)
    assert found[2].share == pytest.approx(0.5, rel=1e-12)
    both = mean_steps(strut, {"STRUT": area(5, 14)}, {"STRUT": np.array([100])})
    assert both[0].share == pytest.approx(1.0, rel=1e-12)


def test_an_area_of_scattered_grids_is_told_of_the_elements_around(strut: ModelGeometry) -> None:
    """A corner has a quarter of one quad; without a majority anywhere, the elements that it touches are its own."""
    found = mean_steps(strut, {"REST": area(*range(2, 19)), "CORNER": area(1)}, {})
    assert found[1].elements.tolist() == [1]
    assert found[1].share == pytest.approx(0.25, rel=1e-12)


def test_what_has_no_volume_is_no_element_of_an_area(tmp_path: Path) -> None:
    """A spring and a bar without section do not expand, whoever selects them."""
    bulk = grids((0, 0, 0), (1, 0, 0), (3, 0, 0)) + "CBAR,1,1,1,2,0.,1.,0.\nCBAR,2,2,2,3,0.,1.,0.\n"
    bulk += "PBAR,1,1,0.,1.-9,1.-9,2.-9\nPBAR,2,1,1.-4,1.-9,1.-9,2.-9\nCELAS1,3,3,1,1,2,1\nPELAS,3,1.+5\n"
    found = geometry_of(tmp_path / "bars.bdf", bulk)
    steps = mean_steps(found, {"A": area(1, 2), "B": area(3)}, {"A": np.array([1, 2, 3])})
    assert [s.elements.tolist() for s in steps] == [[2], [2]]
    assert [s.share for s in steps] == [pytest.approx(0.5), pytest.approx(0.5)]
    assert np.isnan(mean_steps(found, {"A": area(1)}, {})[0].share)


def test_parts_of_a_partition_are_the_whole(strut: ModelGeometry) -> None:
    """Every element is warmed once: what the areas give to all elements sums to the volume of the model."""
    random = np.random.default_rng(3)
    label = random.integers(0, 3, len(strut.grid_id))
    ids = strut.elements.id
    total = 0.0
    volume = np.bincount(
        np.repeat(np.arange(len(ids)), np.diff(strut.elements.node_offset)), node_volumes(strut), len(ids)
    ).sum()
    for k in range(3):
        areas = {f"A{j}": area(*strut.grid_id[label == j]) for j in range(3)}
        step = mean_steps(strut, areas, {f"A{k}": ids})[k]
        assert step.elements.tolist() == ids.tolist()
        total += step.share
    assert volume == pytest.approx(0.02 + 1e-4, rel=1e-12)
    assert total == pytest.approx(1.0, rel=1e-12)


SHAPES = {
    "CHEXA": ((0, 0, 0), (2, 0, 0), (2, 1, 0), (0, 1, 0), (0, 0, 1), (2, 0, 1), (2, 1, 1.5), (0, 1, 1)),
    "CPENTA": ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 0.2, 1), (0, 1, 2)),
    "CTETRA": ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 3)),
    "CPYRAM": ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0.3, 0.5, 3)),
}


@pytest.mark.parametrize("card", SHAPES)
def test_volumes_of_solids_are_their_masses(tmp_path: Path, card: str) -> None:
    """All nodes together: the mass over the density, which other code integrates; each node: its part of a field 1."""
    places = SHAPES[card]
    nodes = [str(i) for i in range(1, len(places) + 1)]
    lines = f"{card},1,1,{','.join(nodes[:6])}\n" + (f",{','.join(nodes[6:])}\n" if nodes[6:] else "")
    kind = "PSOLID,1,1\n"
    geometry = geometry_of(tmp_path / "solid.bdf", grids(*places) + lines + kind)
    volume = node_volumes(geometry)
    assert volume.sum() == pytest.approx(float(geometry.elements.mass_kg[0]) / 2700.0, rel=1e-12)
    if card == "CTETRA":  # 1/4 of 1/2 for each node
        np.testing.assert_allclose(volume, 0.125, rtol=1e-12)
    if card == "CPYRAM":  # the apex has a quarter of the volume of a pyramid
        assert volume[4] == pytest.approx(0.25 * 1.0, rel=1e-12)


def test_warning_names_the_areas_and_the_least_first() -> None:
    ids = np.array([7, 8])
    lines = mean_step_lines([MeanStep("A", 0.9, ids, 0), MeanStep("B", 0.5, ids[:1], 1), MeanStep("C", 0.79, ids, 2)])
    assert lines[0].endswith("50 % (B) to 90 % (A)")
    assert "B 50 % (element 7); C 79 % (2 elements)" in lines[1]
    assert lines[1].startswith("warning: the own elements of 2 areas get less")
    assert len(mean_step_lines([MeanStep("A", 0.8, ids, 2)])) == 1
    assert mean_step_lines([MeanStep("A", float("nan"), ids[:0], 0)]) == []


def test_the_remedy_is_one_that_the_elements_have(tmp_path: Path) -> None:
    """Two solids and a bar from border to border: solids have no temperatures of their own."""
    corners = [(x, y, z) for z in (0, 1, 2) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]
    bulk = grids(*corners, (0, 0, 3)) + "PSOLID,1,1\nPBAR,2,1,1.-4,1.-9,1.-9,2.-9\nCBAR,3,2,9,13,1.,0.,0.\n"
    for k in (0, 1):
        n = [4 * k + i for i in range(1, 9)]
        bulk += f"CHEXA,{k + 1},1,{','.join(map(str, n[:6]))}\n,{n[6]},{n[7]}\n"
    model = geometry_of(tmp_path / "solids.bdf", bulk)
    loads = {"LOW": area(*range(1, 9)), "TOP": area(*range(9, 13)), "TIP": area(13)}
    _, top, tip = mean_steps(model, loads, {"TOP": np.array([2]), "TIP": np.array([3])})
    assert [s.share for s in (top, tip)] == pytest.approx([0.5, 0.5])
    assert [s.carriers for s in (top, tip)] == [0, 1]
    solids, bars, both = (mean_step_lines(steps)[1] for steps in ([top], [tip], [top, tip]))
    assert solids.endswith("(element 2); refine the mesh between the borders")
    assert bars.endswith('; give such an area carrier = "elements", or refine the mesh between the borders')
    assert both.endswith(
        'shells, bars and rods of such an area carrier = "elements"; refine solids between the borders'
    )
