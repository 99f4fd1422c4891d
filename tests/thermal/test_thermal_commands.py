"""build-thermal: what it writes and prints, tables that are left out, and the same network from ESATAN-TMS."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from border_tools import tedm
from thermal_project import NUMBERS, ThermalProject, write_tmd

from tedm_cli.config.thermal.file import load_thermal
from tedm_cli.config.thermal.network import read_network
from tedm_cli.errors import InputError
from tedm_cli.library.build import open_build
from tedm_cli.thermal.linear import linearised, shares
from tedm_cli.thermal.transfer import transfer


@pytest.fixture
def project(tmp_path: Path) -> ThermalProject:
    return ThermalProject(tmp_path / "network")


def test_the_file_holds_what_the_rooms_compute(project: ThermalProject) -> None:
    project.run("build-thermal").ok()
    _, config = load_thermal(project.folder / "thermal.toml")
    assert config.network is not None
    given = read_network(config.network, project.folder.joinpath)
    steady = given.steady()
    share = shares(given.network, [d.place() for d in config.disturbances], where="")
    with project.file() as file:
        assert file["node/name"].asstr()[()].tolist() == ["SC", "SPACE", "SHIELD", "OB", "BOX", "JOINT"]
        assert file["node/free"][()].tolist() == [2, 3, 4, 5]
        assert file["node/free_name"].asstr()[()].tolist() == ["SHIELD", "OB", "BOX", "JOINT"]
        assert file["node/power"][()].tolist() == [0.0, 0.0, 0.0, 0.0, 3.0, 0.0]
        assert file["steady_K"][()] == pytest.approx(steady.temperature_K, rel=1e-15)
        assert file["node/solved"][()].tolist() == [0, 0, 1, 1, 1, 1]
        frequency = file["frequency"][()]
        assert frequency.tolist() == [1e-5, 1e-4, 3e-4, 1e-3, 3e-3, 1e-2]
        H = transfer(linearised(given.network, steady.temperature_K, share), frequency)
        assert file["transfer"].shape == (6, 4, 2)
        assert file["transfer"].dtype == np.complex128
        assert (file["transfer"][()] == H).all()
        assert file["disturbance/share"][()].tolist() == [[1, 0, 0, 0, 0, 0], [0, 0, 0, 0.2, 0.8, 0]]
        asd = np.stack([np.full(6, 1e-3), 1e-2 * (frequency / 1e-5) ** -0.4])
        assert file["disturbance/asd"][()] == pytest.approx(asd, rel=1e-12)
        source = np.array([[1.0, 0.5], [0.5, 1.0]]) * asd.T[:, :, None] * asd.T[:, None, :]
        expected = H @ source @ np.conj(H.transpose(0, 2, 1))
        assert np.abs(file["psd"][()] / expected - 1.0).max() < 1e-12
        assert file["psd"].attrs["units"] == "K^2/Hz"
        for name in ("filter/order", "filter/corner_hz", "filter/error", "static_gain"):
            assert file[name].shape == (4, 2)
        assert "sensitivity" not in file
        assert "map" not in file


def test_what_is_printed(project: ThermalProject) -> None:
    out = project.run("build-thermal").ok().out
    assert "6 nodes (3 diffusive, 1 arithmetic and 2 boundary), 7 conductors" in out
    assert "coldest SPACE 3 K, hottest BOX 297.807 K" in out
    assert "powers 3 W, boundaries take 3 W; largest imbalance of 4 nodes solved for" in out
    assert "gains of 4 nodes at 6 frequencies from 1e-05 to 0.01 Hz; spectra of them all" in out
    with project.file() as file:
        names, S = file["node/free_name"].asstr()[()].tolist(), file["psd"][3]  # at 1 mHz
    power = S.diagonal().real
    pairs = {(a, b): abs(S[i, j]) ** 2 / power[i] / power[j]
             for i, a in enumerate(names) for j, b in enumerate(names) if i < j}  # fmt: skip
    (a, b), least = min(pairs.items(), key=lambda item: item[1])
    median = np.median(list(pairs.values()))
    assert f"coherence of two nodes at 1 mHz: median {median:.3g}, least {least:.3g} ({a} and {b})" in out
    said = json.loads(project.run("build-thermal", "--json").ok().out, parse_constant=pytest.fail)
    assert said["steady"]["hottest"][0] == "BOX"
    assert said["steady"]["power_W"] == 3.0
    assert [d["name"] for d in said["disturbances"]] == ["panel", "bus"]
    assert said["disturbances"][0]["largest"][0][0] == "SHIELD"
    assert said["seconds"] > 0.0
    shown = tedm("show", project.build / "thermal.h5").ok().out
    assert "hottest: BOX, 297.807 K" in shown
    assert "disturbance bus: table" in shown
    assert not project.run("build-thermal", "--quiet").ok().out


def test_the_same_inputs_give_the_same_bytes(project: ThermalProject) -> None:
    project.run("build-thermal").ok()
    first = (project.build / "thermal.h5").read_bytes()
    project.run("build-thermal").ok()
    assert (project.build / "thermal.h5").read_bytes() == first


def test_the_library_reads_it_with_its_labels_until_it_is_stale(project: ThermalProject) -> None:
    project.run("build-thermal").ok()
    found = open_build(project.build).thermal
    with project.file() as file:
        H = file["transfer"][()]
    assert (found.transfer.sel(free="BOX", disturbance="bus").values == H[:, 2, 1]).all()
    assert found.psd.dims == ("frequency", "free", "free_column")
    assert found.steady_K.sel(node="SPACE").item() == 3.0
    project.change("powers.csv", "BOX,2", "BOX,2.5")
    with pytest.raises(InputError, match="stale"):
        _ = open_build(project.build).thermal


def test_without_disturbances_there_is_the_steady_state_alone(project: ThermalProject) -> None:
    text = (project.folder / "thermal.toml").read_text()
    (project.folder / "thermal.toml").write_text(text[: text.index("[frequency]")])
    assert "nothing disturbs it: there are no gains and no spectra" in project.run("build-thermal").ok().out
    with project.file() as file:
        assert "steady_K" in file
        assert "transfer" not in file
        assert "frequency" not in file


def test_without_frequencies_they_are_those_of_the_cases(project: ThermalProject) -> None:
    text = (project.folder / "thermal.toml").read_text()
    cut = text[: text.index("[frequency]")] + text[text.index("[[disturbance]]") :]
    (project.folder / "thermal.toml").write_text(cut)
    project.run("build-thermal").refused(4, "cases.toml", hint="cases.toml")
    case = (
        '[frequency]\nmin_hz = 1e-3\nmax_hz = 1e-2\npoints = 5\n[[case]]\nid = "1"\ntitle = "all"\npartition = "all"\n'
    )
    (project.folder / "cases.toml").write_text(case)
    project.run("build-thermal").ok()
    with project.file() as file:
        assert file["frequency"][()] == pytest.approx(np.geomspace(1e-3, 1e-2, 5), rel=1e-12)
        assert b"cases.toml" in b" ".join(file["provenance/config_path"][()])


def test_frequencies_may_be_a_grid_of_their_own(project: ThermalProject) -> None:
    project.change("thermal.toml", "list_hz = [1e-5, 1e-4, 3e-4, 1e-3, 3e-3, 1e-2]", "min_hz = 1e-5\npoints = 8")
    project.run("build-thermal").ok()
    with project.file() as file:
        frequency = file["frequency"][()]
    assert frequency[[0, -1]].tolist() == [1e-5, 0.1]
    assert np.isin(1e-3, frequency)
    assert len(frequency) == 9
    project.change("thermal.toml", "points = 8", "list_hz = [1e-3]")
    project.run("build-thermal").refused(3, "frequency", "has list_hz, but min_hz given")


def test_a_project_without_a_thermal_model(project: ThermalProject) -> None:
    (project.folder / "tedm.toml").write_text('title = "none"\n')
    project.run("build-thermal").refused(
        3, "thermal: the project has no thermal model", hint='thermal = "thermal.toml"'
    )
    (project.folder / "tedm.toml").write_text('title = "none"\nthermal = "gone.toml"\n')
    project.run("build-thermal").refused(3, "thermal: names 'gone.toml'", hint="leaves the key out")
    (project.folder / "tedm.toml").write_text('title = "none"\nthermal = "thermal.toml"\n')
    (project.folder / "thermal.toml").write_text("")
    project.run("build-thermal").refused(3, "there is no [network] and no [map]", hint="give the network")


def test_temperatures_in_celsius_are_told_by_their_column(project: ThermalProject) -> None:
    project.run("build-thermal").ok()
    with project.file() as file:
        kelvin = file["steady_K"][()]
    project.change("nodes.csv", "temperature_K", "temperature_degC")
    project.change("nodes.csv", "293.15", "20")
    project.change("nodes.csv", "boundary,3\n", "boundary,-270.15\n")
    project.run("build-thermal").ok()
    with project.file() as file:
        assert file["steady_K"][()] == pytest.approx(kelvin, rel=1e-14)


def test_given_temperatures_are_kept_or_begun_from(project: ThermalProject) -> None:
    project.run("build-thermal").ok()
    with project.file() as file:
        solved = file["steady_K"][3]
    project.change("nodes.csv", "5000,diffusive,", "5000,diffusive,250")
    assert "of 1 node given" in project.run("build-thermal").ok().out
    with project.file() as file:
        assert file["steady_K"][3] == 250.0
        assert file["node/solved"][()].tolist() == [0, 0, 1, 0, 1, 1]
        assert abs(file["node/net_heat"][3]) > 1.0
    project.change("thermal.toml", "\n[frequency]", 'temperatures = "start"\n\n[frequency]')
    assert "of 1 node given" not in project.run("build-thermal").ok().out
    with project.file() as file:
        assert file["steady_K"][3] == pytest.approx(solved, rel=1e-11)


def test_columns_that_may_follow_and_semicolons(project: ThermalProject) -> None:
    rows = (project.folder / "nodes.csv").read_text().splitlines()
    placed = [
        rows[0] + ",x_m,y_m,z_m",
        *(f"{row},{0.1 * i},0,-1" for i, row in enumerate(rows[1:-1])),
        rows[-1] + ",,,",
    ]
    text = "\n".join(placed) + "\n"
    (project.folder / "nodes.csv").write_text(text.replace(",", ";").replace(".", ","))
    project.change("nodes.csv", "293,15", "293,65")
    project.run("build-thermal").ok()
    with project.file() as file:
        assert file["steady_K"][0] == 293.65
        assert file["node/position"][1].tolist() == [0.1, 0.0, -1.0]
        assert np.isnan(file["node/position"][5]).all()


def large(project: ThermalProject, n: int = 230) -> None:
    """A chain of `n` nodes behind the shield."""
    with (project.folder / "nodes.csv").open("a") as nodes, (project.folder / "conductors.csv").open("a") as conductors:
        for i in range(n):
            nodes.write(f"C{i},10,diffusive,\n")
            conductors.write(f"{'SHIELD' if i == 0 else f'C{i - 1}'},C{i},1,0\n")


def test_spectra_of_a_large_network_are_of_the_nodes_that_are_named(project: ThermalProject) -> None:
    large(project)
    out = project.run("build-thermal").ok().out
    assert "gains of 234 nodes" in out
    assert "no spectra: these are too many nodes, name some in [output]" in out
    with project.file() as file:
        assert file["transfer"].shape == (6, 234, 2)
        assert "psd" not in file
        whole = file["transfer"][()]
        names = file["node/free_name"].asstr()[()].tolist()
    for chosen in (["C100", "OB", "C3"], ["C7"]):  # the last by the transposed matrix
        (project.folder / "thermal.toml").write_text(
            (project.folder / "thermal.toml").read_text().split("[output]")[0] + f"[output]\nnodes = {chosen}\n"
        )
        project.run("build-thermal").ok()
        with project.file() as file:
            assert file["node/free_name"].asstr()[()].tolist() == chosen
            assert [file["node/name"].asstr()[r] for r in file["node/free"][()]] == chosen
            assert file["psd"].shape == (6, len(chosen), len(chosen))
            rows = [names.index(name) for name in chosen]
            assert np.abs(file["transfer"][()] / whole[:, rows] - 1.0).max() < 1e-11


def test_a_tmd_file_is_the_same_network(project: ThermalProject) -> None:
    project.run("build-thermal").ok()
    with project.file() as file:
        steady, H = file["steady_K"][()], file["transfer"][()]
    names = ["SC", "SPACE", "SHIELD", "OB", "BOX", "JOINT"]
    write_tmd(project.folder / "MODEL.TMD", dict(zip(names, steady.tolist(), strict=True)))
    text = (project.folder / "thermal.toml").read_text()
    text = text.replace(
        'nodes = "nodes.csv"\nconductors = "conductors.csv"\npowers = "powers.csv"', 'tmd = "MODEL.TMD"'
    )
    for name in ("SC", "BOX", "OB"):
        text = text.replace(f'"{name}"', f'"{NUMBERS[name]}"')
    (project.folder / "thermal.toml").write_text(text)
    project.run("build-thermal").ok()
    with project.file() as file:
        assert file["node/name"].asstr()[()].tolist() == ["1", "2", "10", "20", "30", "40"]
        assert file["node/kind"].asstr()[()].tolist()[-1] == "arithmetic"
        assert file["steady_K"][()] == pytest.approx(steady, rel=1e-13)
        assert np.abs(file["node/net_heat"][2:]).max() < 1e-10  # in balance with its powers
        assert np.abs(file["transfer"][()] / H - 1.0).max() < 1e-11
    (project.folder / "thermal.toml").write_text(text.replace('"MODEL.TMD"', '"MODEL.TMD"\ntime_s = 0.0'))
    project.run("build-thermal").ok()
    with project.file() as file:
        assert file["steady_K"][2] == 273.15  # 0 degC at the first time
