"""Temperature series of thermal nodes on the small sample: y = s (τ - τ_ref), whatever file τ is in."""

from __future__ import annotations

import json
import shutil
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest

sys.path.append(str(Path(__file__).parents[1] / "borders"))

from border_tools import Outcome, tedm
from test_chain_thermal import SMALL, project_in

from tedm_cli.chain.graph import chain_of
from tedm_cli.config.project import Project, load_project
from tedm_cli.stages.chain.project_files import chain_files

STEP, ROWS = 20.0, 400
HEAD = '[frequency]\npoints = 61\n[[case]]\nid = "1"\ntitle = "all"\npartition = "all"\n'
SERIES = '\n[[series]]\nname = "{name}"\nfile = "{file}"\nremove = "{remove}"\n{more}\n'


class Small:
    """A project of the small sample whose cases file is one series."""

    def __init__(self, project: Project) -> None:
        self.project = project
        self.folder, self.build = project.file.path.parent, project.build_dir

    def run(self, *args: object) -> Outcome:
        return tedm(*args, "-c", self.project.file.path, "-d", self.build)

    def configure(
        self, file: str = "t.csv", remove: str = "nothing", more: str = 'of = "nodes"', name: str = "n"
    ) -> None:
        text = HEAD + SERIES.format(name=name, file=file, remove=remove, more=more)
        (self.folder / "cases.toml").write_text(text)

    def series(self, name: str = "n") -> dict[str, np.ndarray]:
        with h5py.File(self.build / f"series_{name}.h5") as file:
            return {label: file[f"series/{label}"][()] for label in file["output/label"].asstr()[()]}

    def sensitivity(self) -> tuple[list[str], dict[str, np.ndarray]]:
        with h5py.File(self.build / "thermal.h5") as t:
            rows = dict(zip(t["row/label"].asstr()[()].tolist(), t["sensitivity"][()], strict=True))
            return t["map/node"].asstr()[()].tolist(), rows


def write_csv(path: Path, names: list[str], tau: np.ndarray, step: float = STEP) -> None:
    """tau [T, n]."""
    table = np.column_stack([step * np.arange(len(tau)), tau])
    np.savetxt(path, table, "%.17g", ",", header=",".join(["time_s", *names]), comments="")


def write_tmd(path: Path, numbers: list[str], tau: np.ndarray, **attributes: float) -> None:
    """Nodes of these numbers, and one that is inactive; the capacity is the first quantity."""
    n = len(numbers) + 1
    real = np.zeros((len(tau), n, 2))
    real[:, :-1, 1] = tau
    with h5py.File(path, "w") as file:
        group = file.create_group("AnalysisSet1")
        group["thermalNodes"] = np.array([*map(int, numbers), 999_999], dtype=np.int32)
        group["thermalNodesRealAttributes"] = np.array(["C", "T"], dtype="S4")
        group["thermalNodesStringAttributes"] = np.array(["TYPE"], dtype="S4")
        group["DataGroup1/times"] = STEP * np.arange(len(tau))
        group["DataGroup1/thermalNodesRealData"] = real
        group["DataGroup1/thermalNodesStringData"] = np.array([[["D"]] * (n - 1) + [["X"]]] * len(tau)).astype("S4")
        for name, value in attributes.items():
            group.attrs[name] = value


@pytest.fixture(scope="module")
def built(small: Project, tmp_path_factory: pytest.TempPathFactory) -> Small:
    """With thermal.h5 of the elements of the sample's nodes and the network. Not to be changed."""
    thermal = (SMALL / "thermal.toml").read_text(encoding="utf-8")
    for name in ("nodes", "conductors", "powers", "elements"):
        thermal = thermal.replace(f'"thermal_{name}.csv"', f'"{SMALL}/thermal_{name}.csv"')
    project = project_in(tmp_path_factory.mktemp("nodes") / "p", small, thermal, HEAD)
    done = Small(project)
    done.run("build-thermal").ok()
    return done


@pytest.fixture
def net(built: Small, tmp_path: Path) -> Small:
    """A copy that may be changed; its frequencies are those of the thermal model's file as built."""
    shutil.copytree(built.folder, tmp_path / "p")
    return Small(load_project(tmp_path / "p" / "tedm.toml", tmp_path / "p" / "build"))


@pytest.fixture(scope="module")
def by_number(small: Project, tmp_path_factory: pytest.TempPathFactory) -> Small:
    """Nodes 1, 2, ... each of which is an area, without a network."""
    with h5py.File(small.build_dir / "sensitivity.h5") as file:
        areas = file["area/name"].asstr()[()].tolist()
    project = project_in(tmp_path_factory.mktemp("areas") / "p", small, '[map]\nweights = "weights.csv"\n', HEAD)
    lines = [f"{number},{area},1" for number, area in enumerate(areas, start=1)]
    (project.file.path.parent / "weights.csv").write_text("\n".join(["node,area,weight", *lines]) + "\n")
    done = Small(project)
    done.run("build-thermal").ok()
    return done


def noise(columns: int, seed: int = 3) -> np.ndarray:
    return 1e-3 * np.random.default_rng(seed).standard_normal((ROWS, columns))


def test_series_are_the_product_with_the_sensitivity(net: Small) -> None:
    """To rounding, in any order of columns, with nodes of the network that are not on the model beside them."""
    names, rows = net.sensitivity()
    tau = noise(len(names))
    order = np.random.default_rng(4).permutation(len(names))
    with h5py.File(net.build / "thermal.h5") as file:
        extra = [n for n in file["node/name"].asstr()[()] if n not in names][:3]
    write_csv(net.folder / "t.csv", [*extra, *(names[i] for i in order)], np.hstack([noise(3, 9), tau[:, order]]))
    net.configure()
    out = net.run("run-series", "n").ok().out
    assert f"of {len(names)} thermal nodes, nothing removed, as sampled; not on the model: {', '.join(extra)}" in out
    found = net.series()
    assert len(found) == 24
    for label, y in found.items():
        np.testing.assert_allclose(y, tau @ rows[label], rtol=0, atol=1e-12 * np.abs(rows[label]).sum() * 1e-3)
    with h5py.File(net.build / "series_n.h5") as file:
        assert file["area/name"].asstr()[()].tolist() == names
        assert file["temperature/column"].asstr()[()].tolist() == names
        assert "thermal.h5" in " ".join(map(str, file["provenance/input_path"].asstr()[()]))
    assert "series_n.h5: series" in tedm("show", net.build / "series_n.h5").ok().out
    assert json.loads(net.run("run-series", "n", "--json").ok().out)[0]["treatment"].startswith("of ")


def test_a_constant_field_is_the_uniform_one_and_a_sine_keeps_its_amplitude(net: Small) -> None:
    names, rows = net.sensitivity()
    net.configure(remove="reference", more='of = "nodes"\nreference = 293.15')
    write_csv(net.folder / "t.csv", names, np.full((ROWS, len(names)), 293.4))
    net.run("run-series", "n").ok()
    with h5py.File(net.build / "sensitivity.h5") as s:
        uniform = dict(zip(s["row/label"].asstr()[()].tolist(), s["S"][()].sum(axis=1), strict=True))
    found = net.series()
    size = {label: np.abs(row).sum() for label, row in rows.items()}
    for label in uniform:
        assert np.abs(found[label] - 0.25 * uniform[label]).max() < 1e-6 * size[label]
    phase = np.random.default_rng(1).uniform(0, 2 * np.pi, len(names))
    amplitude = 1e-3 * np.exp(1j * phase)
    turn = 2.0 * np.pi * 10 / ROWS * np.arange(ROWS)
    net.configure(remove="mean")
    write_csv(net.folder / "t.csv", names, 20.0 + np.real(np.exp(1j * turn)[:, None] * amplitude))
    net.run("run-series", "n").ok()
    for label, y in net.series().items():
        line = 2.0 / ROWS * abs(np.sum(y * np.exp(-1j * turn)))
        assert line == pytest.approx(abs(rows[label] @ amplitude), rel=1e-9, abs=1e-9 * size[label] * 1e-3)


def test_one_node_per_area_is_the_area_route(by_number: Small, tmp_path: Path) -> None:
    names, _ = by_number.sensitivity()
    with h5py.File(by_number.build / "sensitivity.h5") as file:
        areas = file["area/name"].asstr()[()].tolist()
    tau = 293.0 + noise(len(names))
    write_csv(by_number.folder / "t.csv", names, tau)
    by_number.configure(remove="linear")
    by_number.run("run-series", "n").ok()
    of_nodes = by_number.series()
    write_csv(by_number.folder / "t.csv", areas, tau)
    by_number.configure(remove="linear", more="")
    by_number.run("run-series", "n").ok()
    for label, y in by_number.series().items():
        assert np.abs(of_nodes[label] - y).max() < 1e-6 * np.abs(y).max()


def test_the_loop_feels_nodes_as_it_feels_their_areas(by_number: Small) -> None:
    names, _ = by_number.sensitivity()
    with h5py.File(by_number.build / "sensitivity.h5") as file:
        areas = file["area/name"].asstr()[()].tolist()
    by_number.configure(remove="mean")
    by_number.run("build-dynamics").ok()
    found = []
    for heads, more in ((names, 'of = "nodes"'), (areas, "")):
        write_csv(by_number.folder / "t.csv", heads, 293.0 + noise(len(names)), 10.0)
        by_number.configure(remove="mean", more=more)
        by_number.run("simulate", "--series", "n").ok()
        with h5py.File(by_number.build / "simulation_n.h5") as file:
            parts = ("series", "gravity/series", "read_out/series")
            found.append({f"{part}/{name}": file[part][name][()] for part in parts for name in file[part]})
    assert found[0].keys() == found[1].keys()
    for name, y in found[0].items():
        assert np.abs(y - found[1][name]).max() <= 1e-6 * np.abs(y).max()
    assert any(np.abs(y).max() > 0.0 for y in found[0].values())


def test_esatan_csv_and_hdf5_give_equal_bits_and_kelvins_what_degrees_do(by_number: Small) -> None:
    names, _ = by_number.sensitivity()
    tau = 20.0 + noise(len(names))
    write_csv(by_number.folder / "t.csv", names, tau)
    write_tmd(by_number.folder / "t.TMD", names, tau, TAbs=273.15)
    with h5py.File(by_number.folder / "t.h5", "w") as file:
        file["time_s"] = STEP * np.arange(ROWS)
        for name, column in zip(names, tau.T, strict=True):
            file[name] = column
    found = []
    for file, unit in (("t.csv", '\nunit = "degC"'), ("t.TMD", ""), ("t.h5", '\nunit = "degC"')):
        by_number.configure(file, "linear", f'of = "nodes"{unit}')
        assert "degrees Celsius, of which only differences count" in by_number.run("run-series", "n").ok().out
        found.append(by_number.series())
    for label, y in found[0].items():
        assert (found[1][label] == y).all()
        # Columns of HDF5 come in the order of their names, so that sums round otherwise.
        assert np.abs(found[2][label] - y).max() <= 1e-12 * np.abs(y).max() + 1e-30
    write_tmd(by_number.folder / "t.tmd", names, tau + 273.15, TAbs=0.0)
    by_number.configure("t.tmd", "linear")
    assert "Celsius" not in by_number.run("run-series", "n").ok().out
    for label, y in by_number.series().items():
        assert np.abs(found[0][label] - y).max() <= 1e-9 * np.abs(y).max()


def test_weights_take_the_nodes_of_esatan_too(by_number: Small) -> None:
    """The old way, nodes to areas with weights, from the same file."""
    names, _ = by_number.sensitivity()
    tau = 20.0 + noise(len(names))
    write_tmd(by_number.folder / "t.TMD", names, tau, TAbs=273.15)
    by_number.configure("t.TMD", "mean")
    by_number.run("run-series", "n").ok()
    of_nodes = by_number.series()
    by_number.configure("t.TMD", "mean", 'weights = "weights.csv"')
    by_number.run("run-series", "n").ok()
    for label, y in by_number.series().items():
        assert np.abs(of_nodes[label] - y).max() < 1e-6 * np.abs(y).max()


def test_what_a_tmd_does_not_say_is_asked_for(by_number: Small) -> None:
    names, _ = by_number.sensitivity()
    write_tmd(by_number.folder / "t.TMD", names, 20.0 + noise(len(names)))
    by_number.configure("t.TMD", "mean")
    by_number.run("run-series", "n").refused(4, "has no attribute TAbs", hint='unit = "degC" (or "K") in [[series]]')
    by_number.configure("t.TMD", "mean", 'of = "nodes"\nunit = "degC"')
    by_number.run("run-series", "n").ok()
    write_tmd(by_number.folder / "t.TMD", names, 20.0 + noise(len(names)), TAbs=0.0)
    by_number.run("run-series", "n").refused(4, "in K by the attribute TAbs, but unit is degC", hint="[[series]]")
    by_number.configure("t.TMD")
    by_number.run("run-series", "n").refused(3, "temperatures of a TMD file are no deviations")
    by_number.configure("t.TMD", "mean")
    write_tmd(
        by_number.folder / "t.TMD", names, np.where(np.arange(ROWS)[:, None] == 7, np.nan, noise(len(names))), TAbs=0.0
    )
    by_number.run("run-series", "n").refused(4, "t.TMD: time 8", "is nan")
    write_tmd(by_number.folder / "t.TMD", names[1:], noise(len(names) - 1), TAbs=0.0)
    by_number.run("run-series", "n").refused(4, f"no column for 1 of {len(names)} thermal nodes: 1")


@pytest.mark.parametrize(
    ("columns", "more", "code", "fact", "hint"),
    [
        (lambda n: n[2:], "", 4, "no column for 2 of", "`constant`"),
        (lambda n: [*n, "NOWHERE"], "", 4, "columns that are no thermal node: NOWHERE", "`unused`"),
        (lambda n: [n[0].lower(), *n[1:]], "", 4, "columns that are no thermal node: ", "did you mean"),
        (lambda n: [*n[1:], "all"], "", 4, "no column for 1 of", "`constant`"),
        (lambda n: [*n, n[0]], "", 4, "is there twice", ""),
        (lambda n: n, 'unused = ["N*"]', 3, "no column that is not on the model has 'N*'", ""),
        (lambda n: n, 'constant = ["NO*"]', 3, "no thermal node has 'NO*'", ""),
        (lambda n: n, 'weights = "w.csv"', 3, 'with of = "nodes" the map', ""),
    ],
)  # fmt: skip
def test_columns_that_do_not_fit(net: Small, columns, more: str, code: int, fact: str, hint: str) -> None:
    heads = columns(net.sensitivity()[0])
    write_csv(net.folder / "t.csv", heads, noise(len(heads)))
    net.configure(more=f'of = "nodes"\n{more}')
    net.run("run-series", "n").refused(code, fact, hint=hint)
    assert not (net.build / "series_n.h5").exists()


def test_columns_that_are_said_to_be_no_matter(net: Small) -> None:
    names, rows = net.sensitivity()
    tau = noise(len(names))
    write_csv(net.folder / "t.csv", [*names[1:], "NOWHERE"], np.hstack([tau[:, 1:], tau[:, :1]]))
    net.configure(more=f'of = "nodes"\nunused = ["NO*"]\nconstant = ["{names[0]}"]')
    net.run("run-series", "n").ok()
    for label, y in net.series().items():
        assert y == pytest.approx(tau[:, 1:] @ rows[label][1:], abs=1e-15 * np.abs(rows[label]).sum())


def test_what_else_is_refused(net: Small) -> None:
    names, _ = net.sensitivity()
    net.configure(more='of = "nodes"\nunit = "degC"')
    net.run("run-series", "n").refused(3, 'unit = "degC" needs remove')
    net.configure(remove="reference")
    net.run("run-series", "n").refused(3, "reference and remove")
    tau = noise(len(names))
    write_csv(net.folder / "t.csv", names, np.where(np.arange(ROWS)[:, None] == 5, np.nan, tau))
    net.configure()
    net.run("run-series", "n").refused(4, "t.csv:7", "is nan")
    table = np.column_stack([STEP * np.arange(ROWS), tau])[[0, 1, 3, 2, *range(4, ROWS)]]
    np.savetxt(net.folder / "t.csv", table, "%.9g", ",", header=",".join(["time_s", *names]), comments="")
    net.run("run-series", "n").refused(4, "t.csv:", hint="stamps must")
    write_csv(net.folder / "t.csv", names, 3e5 + tau)
    net.run("run-series", "n").refused(4, "is outside -10000 to 10000 K")
    write_csv(net.folder / "t.csv", names, tau)
    text = (net.folder / "thermal.toml").read_text()
    (net.folder / "thermal.toml").write_text(text + "# changed\n")
    net.run("run-series", "n").refused(4, "thermal.h5: is stale", hint="build-thermal")
    (net.folder / "thermal.toml").write_text(text.split("[map]")[0])
    net.run("run-series", "n").refused(3, "has no [map], which series n is made of")
    (net.folder / "thermal.toml").write_text(text)
    (net.build / "thermal.h5").unlink()
    net.run("run-series", "n").refused(4, "no such file; series n of", hint="build-thermal")
    project = net.folder / "tedm.toml"
    project.write_text(project.read_text().replace('thermal = "thermal.toml"\n', ""))
    net.run("run-series", "n").refused(3, "has no thermal model")


def test_the_chain_makes_it_from_the_network(net: Small) -> None:
    names, _ = net.sensitivity()
    write_csv(net.folder / "t.csv", names, noise(len(names)))
    net.configure()
    steps = {step.words: step.inputs for step in chain_of(chain_files(net.project))}
    assert net.build / "thermal.h5" in steps["run-series n"]
    assert net.build / "thermal.h5" in steps["simulate --series n"]
    assert net.folder / "t.csv" in steps["run-series n"]


def test_a_network_in_time_has_the_spectra_of_its_case(net: Small) -> None:
    """The network stepped by a realisation, its temperatures through the sensitivities, against the exact spectra."""
    case = '\n[[case]]\nid = "T"\ntitle = "network"\nthermal = true\n'
    net.run("simulate-thermal", "--duration", "2e5", "--seed", "5", "-o", net.folder / "t.h5").ok()
    net.configure("t.h5", more='of = "nodes"\nlowest_hz = 2e-3')
    with (net.folder / "cases.toml").open("a") as file:
        file.write(case)
    net.run("run-case", "T").ok()
    net.run("run-series", "n").ok()
    with h5py.File(net.build / "series_n.h5") as s, h5py.File(net.build / "caseT.h5") as exact:
        f, nu, known = s["frequency"][()], s["degrees_of_freedom"][()], exact["frequency"][()]
        at = np.arange(0, np.searchsorted(f, 0.05), 8)  # bins that are independent of each other
        ratios = {}
        for label in exact["output/label"].asstr()[()]:
            psd = np.exp(np.interp(np.log(f[at]), np.log(known), np.log(exact[f"psd/{label}"][()])))
            ratios[label] = s[f"psd/{label}"][()][at] / psd
    assert len(ratios) == 24
    assert nu[0] > 60
    assert len(at) > 60
    spread = np.sqrt(2.0 / nu[0])
    for label, ratio in ratios.items():
        assert ratio.mean() == pytest.approx(1.0, abs=4.5 * spread / np.sqrt(len(at))), label
        assert ratio.std() == pytest.approx(spread, rel=0.4), label
