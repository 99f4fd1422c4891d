"""What temperatures of thermal nodes do, by an adjoint with all that there may be: elements with temperatures of their
own, and parts that do not pass through the structure."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
from border_tools import tedm
from strut_model import LOWER, UPPER, deck, define, project

from tedm_cli.config.thermal.file import load_thermal
from tedm_cli.config.thermal.map import MapTable
from tedm_cli.noise.areas import AreaTable
from tedm_cli.results.adjoint.temperatures import TemperatureEffects
from tedm_cli.stages.thermal.map import on_grids, sensitivity
from tedm_cli.stages.thermal.map_build import Mapping, build_map
from tedm_cli.stages.thermal.map_model import FiniteElements, finite_elements

RANDOM = np.random.default_rng(23)
K = "[map.conductivity_W_m_K]\n1 = 150.0\n2 = 7.0\n"


@pytest.fixture(scope="module")
def plates(tmp_path_factory: pytest.TempPathFactory) -> FiniteElements:
    """Two plates on four struts of two bars, which have temperatures of their own in an area of elements."""
    struts = define("STRUTS", property=2, carrier='"elements"')
    return finite_elements(project(tmp_path_factory.mktemp("plates"), deck(2), LOWER + UPPER + struts))


def table(folder: Path, text: str) -> MapTable:
    path = folder / "thermal.toml"
    path.write_text(text)
    found = load_thermal(path)[1].map
    assert found is not None
    return found


def mapped(fem: FiniteElements, text: str) -> Mapping:
    return build_map(fem, table(fem.source.parent, text), fem.source.parent / "thermal.toml")


def effects(fem: FiniteElements) -> TemperatureEffects:
    """Random ones of three outputs; the bars have temperatures of their own."""
    names = list(fem.areas)
    bars = fem.geometry.elements.id[np.array(fem.geometry.elements.type) == "CBAR"]
    k = len(names)
    return TemperatureEffects(
        label=["a", "b", "c"],
        unit=["m/K"] * 3,
        grid_id=fem.geometry.grid_id,
        grid=RANDOM.normal(size=(3, len(fem.geometry.grid_id))),
        own_id=bars,
        own=RANDOM.normal(size=(3, len(bars))),
        areas=AreaTable(
            np.array(names), np.array(["all"] * k), np.array(["inside"] * k), np.array(["mid"] * k), np.zeros((k, 3))
        ),
        of_area=RANDOM.normal(size=(3, k)),
        direct=np.where(np.arange(k) == names.index("UPPER"), RANDOM.normal(size=(3, k)), 0.0),
    )


def test_a_field_is_felt_by_all_elements_and_by_what_is_direct(plates: FiniteElements) -> None:
    """Element by element: grids, bars by the mean of their ends, and the upper plate's own mean."""
    found, through = effects(plates), mapped(plates, "[map]\nareas = true\n" + K)
    assert through.node == ["LOWER", "UPPER", "STRUTS"]
    fields = through.through.temperatures(np.eye(3))
    e = plates.geometry.elements
    grids = {int(i): e.node_index[a:b] for i, a, b in zip(e.id, e.node_offset[:-1], e.node_offset[1:], strict=True)}
    wanted = found.grid @ fields
    for column, bar in enumerate(found.own_id.tolist()):
        wanted += found.own[:, [column]] * fields[grids[bar]].mean(axis=0)
    upper = np.mean([fields[grids[i]].mean(axis=0) for i in range(1001, 1049)], axis=0)
    wanted += found.direct[:, [1]] * upper
    value = sensitivity(through, found)
    np.testing.assert_allclose(value, wanted, rtol=0, atol=1e-11 * np.abs(wanted).max())
    np.testing.assert_allclose(upper, [0.0, 1.0, 0.0], atol=1e-12)
    assert np.abs(on_grids(found, through) - found.grid).max() > 0.1
    total = found.grid.sum(axis=1) + found.own.sum(axis=1) + found.direct.sum(axis=1)
    np.testing.assert_allclose(value.sum(axis=1), total, rtol=1e-10)


def test_what_is_direct_of_an_area_without_a_node_stays_with_it(plates: FiniteElements) -> None:
    """Bars and plates that share grids are one part, so the plates are cut from the struts here: no bar conducts."""
    found = effects(plates)
    text = '[map]\nunmapped = ["UPPER"]\n[[map.node]]\nname = "N"\nbox = { z_m = [-inf, 0.05] }\nproperty = 1\n'
    with pytest.raises(Exception, match="UPPER has 63 grids that conduction joins to thermal nodes"):
        mapped(plates, text + K)
    through = mapped(plates, '[[map.node]]\nname = "N"\nelement = "1:48"\n' + K)
    np.testing.assert_allclose(sensitivity(through, found)[:, 0], sum_of(found), rtol=1e-10)


def sum_of(found: TemperatureEffects) -> np.ndarray:
    """One node alone is the same temperature everywhere."""
    return np.asarray(found.grid.sum(axis=1) + found.own.sum(axis=1) + found.direct.sum(axis=1))


def test_weights_are_columns_of_areas(plates: FiniteElements) -> None:
    found = effects(plates)
    (plates.source.parent / "w.csv").write_text("node,area,weight\nX,LOWER,1\nX,UPPER,0.25\nY,UPPER,0.75\nY,STRUTS,1\n")
    value = sensitivity(mapped(plates, '[map]\nweights = "w.csv"\n'), found)
    s = found.of_area
    np.testing.assert_allclose(
        value, np.stack([s[:, 0] + 0.25 * s[:, 1], 0.75 * s[:, 1] + s[:, 2]], axis=1), rtol=1e-14
    )


def test_conductances_through_the_struts(plates: FiniteElements) -> None:
    """Four struts in parallel carry k A / L each: by the heat that flows from plate to plate, μ of the nodes."""
    from strut_model import AREA, LENGTH

    from tedm_cli.fem.conduction import conduction_matrix
    from tedm_cli.nastran.conductivity import conductors

    found = conductors(plates.model, plates.geometry, {1: 1e5, 2: 7.0}, "thermal.toml")  # plates that are isothermal
    k = conduction_matrix(found.mesh)
    nodes = "".join(
        f'[[map.node]]\nname = "{n}"\nelement = "{ids}"\n' for n, ids in (("L", "1:48"), ("U", "1001:1048"))
    )
    through = mapped(plates, nodes + K.replace("150.0", "1e5"))
    field = through.through.temperatures(np.array([[0.0], [1.0]]))[:, 0]
    assert field @ (k @ field) == pytest.approx(4 * 7.0 * AREA / LENGTH, rel=1e-3)


def test_areas_of_elements_have_no_field_over_grids(plates: FiniteElements, tmp_path: Path) -> None:
    """As weights they are refused for cards and tables of grids; a map by conduction of the same areas is not."""
    folder = tmp_path / "plates"
    shutil.copytree(plates.source.parent, folder)
    file = folder / "tedm.toml"
    file.write_text(file.read_text() + 'thermal = "thermal.toml"\n')
    (folder / "tau.csv").write_text("set,LOWER,UPPER,STRUTS\na,0,1,3\n")
    (folder / "w.csv").write_text("node,area,weight\n" + "".join(f"{a},{a},1\n" for a in plates.areas))
    (folder / "thermal.toml").write_text('[map]\nweights = "w.csv"\n')
    command = ["map-temperatures", folder / "tau.csv", "-c", file, "-d", folder / "build"]
    tedm(*command).refused(4, "areas that warm elements and not grids: STRUTS")
    (folder / "thermal.toml").write_text("[map]\nareas = true\n" + K)
    tedm(*command).ok()
