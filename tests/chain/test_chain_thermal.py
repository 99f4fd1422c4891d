"""A case of the thermal network on the small sample: by NumPy from the files, and as the cases that it can become."""

from __future__ import annotations

import csv
import json
import re
import shutil
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest

sys.path += [str(Path(__file__).parents[1] / folder) for folder in ("borders", "report")]

from border_tools import Outcome, tedm
from shared_folder import shared
from shipped_cases import cases_of_areas

from tedm_cli.chain.graph import chain_of
from tedm_cli.config.project import Project, load_project
from tedm_cli.contracts import CASE
from tedm_cli.files.store import open_checked
from tedm_cli.report.document import Table
from tedm_cli.report.network_case import network_case_section, network_correlation_section
from tedm_cli.results.cases.file import read_case
from tedm_cli.results.wording import power_text, ratio_text
from tedm_cli.stages.chain.project_files import chain_files

ROOT = Path(__file__).parents[2]
SMALL = ROOT / "sample_models" / "small"
CASE_T = '\n[[case]]\nid = "T"\ntitle = "Thermal network"\nreason = "Computed."\nthermal = true\n'
GRAVITY, READ_OUT = "TM1_a_x", "A_TM1_x"
DIFFERENCE = """
[[requirement]]
name = "lisa_acceleration_differential"
outputs = ["TM1_a_x-TM2_a_x"]
applies_to = "differential"
"""


def project_in(folder: Path, small: Project, thermal: str, cases: str) -> Project:
    """The small sample, built up to the adjoint, with these files."""
    folder.mkdir(exist_ok=True)
    shutil.copytree(small.build_dir, folder / "build")
    model, optics = SMALL / "model.toml", ROOT / "configs" / "optics.toml"
    (folder / "tedm.toml").write_text(
        f'title = "small"\nmodel = "{model}"\noptics = "{optics}"\ncases = "cases.toml"\nthermal = "thermal.toml"\n'
    )
    (folder / "thermal.toml").write_text(thermal)
    (folder / "cases.toml").write_text(cases)
    return load_project(folder / "tedm.toml", folder / "build")


def command(project: Project, *args: object) -> Outcome:
    return tedm(*args, "-c", project.file.path, "-d", project.build_dir)


def white(cases: str) -> str:
    """The cases file with the same white temperatures everywhere."""
    old = (
        'preset = "thesis"\noutside_K = 1e-3     # K/√Hz at reference_hz, outside the thermal shield\ninside_K = 1e-4 '
    )
    assert old in cases
    cases = cases.replace(old, 'preset = "white"\noutside_K = 1e-4\ninside_K = 1e-4 ')
    for key in ("reference_hz = 1e-3\n", "order = 2\n", "corner_hz = 1e-3\n"):
        assert key in cases
        cases = cases.replace(key, "", 1)
    return cases


@pytest.fixture(scope="module")
def shipped() -> str:
    return cases_of_areas()


def network_case(small: Project, shipped: str, factory: pytest.TempPathFactory) -> Project:
    """The small sample with its network; case T was run. Not to be changed: other files of tests have it too."""
    thermal = (SMALL / "thermal.toml").read_text(encoding="utf-8")
    for name in ("nodes", "conductors", "powers", "elements"):
        thermal = thermal.replace(f'"thermal_{name}.csv"', f'"{SMALL}/thermal_{name}.csv"')

    def build(folder: Path) -> None:
        project = project_in(folder, small, thermal, shipped + DIFFERENCE + CASE_T)
        command(project, "build-thermal").ok()
        command(project, "run-case", "T").ok()

    folder = shared(factory, "network_case", build)
    return load_project(folder / "tedm.toml", folder / "build")


@pytest.fixture(scope="module")
def sample(small: Project, shipped: str, tmp_path_factory: pytest.TempPathFactory) -> Project:
    return network_case(small, shipped, tmp_path_factory)


def test_spectra_by_numpy_from_the_files(sample: Project) -> None:
    """S_y = s P H S_u (s P H)ᴴ of self-gravity and read-outs, and of a difference, with the correlations given."""
    with h5py.File(sample.build_dir / "thermal.h5") as t, h5py.File(sample.build_dir / "caseT.h5") as case:
        free, mapped, labels = (t[p].asstr()[:].tolist() for p in ("node/free_name", "map/node", "row/label"))
        at = [free.index(name) for name in mapped]
        asd, correlation = t["disturbance/asd"][:], t["disturbance/correlation"][:]
        assert (correlation != np.eye(len(correlation))).any()
        s = dict(zip(labels, t["sensitivity"][:], strict=True))
        s["TM1_a_x-TM2_a_x"] = s["TM1_a_x"] - s["TM2_a_x"]
        for label in (GRAVITY, READ_OUT, "TM1_a_x-TM2_a_x"):
            wanted = []
            for f, h in enumerate(t["transfer"][:]):
                row = (s[label] @ h[at]) * asd[:, f]
                wanted.append((row @ correlation @ row.conj()).real)
            np.testing.assert_allclose(case[f"psd/{label}"][:], wanted, rtol=1e-10)
            outputs = case["output/label"].asstr()[:].tolist()
            np.testing.assert_allclose(case["disturbance/share"][outputs.index(label)].sum(), 1.0, rtol=1e-12)
        assert case["area/name"].asstr()[:].tolist() == mapped
        assert {"struts", "OB"} <= set(case["area/group"].asstr()[:])
        bench = case["area/group"].asstr()[:][np.char.startswith(np.array(mapped), "OB_")]
        assert set(bench) == {"OB"}


def test_printed_and_read_by_others(sample: Project, tmp_path: Path) -> None:
    """-v names disturbances and what each may be; --json too; what cannot take it says so."""
    out = command(sample, "run-case", "T", "-v", "-o", tmp_path / "t.h5").ok().out
    assert "disturbances: electronics_1 " in out
    assert "level of a disturbance that just meets it: panel_minus_x x " in out
    assert re.search(r"correlation of case T at 1 mHz: case \w+ resembles it best", out)
    told = json.loads(command(sample, "run-case", "T", "-v", "--json", "-o", tmp_path / "t.h5").ok().out)
    (one,) = told["cases"] if isinstance(told, dict) else told
    assert "1" in one["deviation_from_case"]
    assert "7" not in one["deviation_from_case"]  # diagnostic
    assert sum(one["sensitivity"][0]["disturbance_share"].values()) == pytest.approx(1.0)
    assert "temperatures of the thermal network" in command(sample, "explain", "T").ok().out
    tedm("show", sample.build_dir / "caseT.h5").ok()
    build = ("-d", sample.build_dir)
    tedm("export-case", "T", "--format", "csv", "-o", tmp_path / "csv", *build).ok()
    said = tedm("export-extremal", "T", "--of", READ_OUT, "-o", tmp_path / "e", *build).ok().out
    assert "no case takes them" in said
    reaches_its_bound(sample, tmp_path / "e")
    mesh = tmp_path / "mesh.vtu"
    tedm("export-vtu", "-o", mesh, *build).ok()  # of nothing: the only verdicts are of thermal nodes
    assert "_caseT" not in mesh.with_name("mesh_arrays.csv").read_text()
    tedm("export-vtu", "--case", "T", "--of", "TM1_a_x-TM2_a_x", "-o", mesh, *build).ok()
    assert "share_TM1_a_x-TM2_a_x_caseT" in mesh.with_name("mesh_arrays.csv").read_text()
    tedm("export-vtu", "--case", "T", "-o", mesh, *build).ok()
    assert re.search(r"share_\w+_caseT", mesh.with_name("mesh_arrays.csv").read_text())
    system = command(sample, "export-state-space", "T", "--json", "-o", tmp_path / "system").ok()
    told = json.loads(system.out)
    (made,) = told if isinstance(told, list) else told["cases"]
    assert made["states"] > 60
    assert made["output_deviation"] < 1e-3


def reaches_its_bound(sample: Project, folder: Path) -> None:
    """The spectra of the nodes with the correlations of the files make the bounds of the case file."""
    names = {"minimum", "maximum_non_negative", "maximum"}
    assert {path.name for path in folder.iterdir()} == {f"{READ_OUT}_{name}.csv" for name in names}
    with h5py.File(sample.build_dir / "caseT.h5") as case, h5py.File(sample.build_dir / "thermal.h5") as t:
        at = case["output/label"].asstr()[:].tolist().index(READ_OUT)
        f = int(np.abs(case["frequency"][:] - case["contribution/frequency"][at]).argmin())
        row = t["sensitivity"][t["row/label"].asstr()[:].tolist().index(READ_OUT)]
        h = row * case["temperature/asd"][:][case["temperature/spectrum"][:], f]
        for name in names:
            head, *lines = list(csv.reader((folder / f"{READ_OUT}_{name}.csv").open()))
            assert head[1:] == t["map/node"].asstr()[:].tolist()
            matrix = np.array([line[1:] for line in lines], dtype=float)
            assert np.linalg.eigvalsh(matrix).min() > -1e-9
            wanted, size = case[f"bounds/{name}/{READ_OUT}"][f], np.abs(h).sum() ** 2
            np.testing.assert_allclose(h @ matrix @ h, wanted, rtol=1e-9, atol=1e-12 * size)


def test_the_report_tells_it_beside_the_others(sample: Project) -> None:
    """Ratios, levels and correlations by hand from the files; nothing of it without such a case."""
    command(sample, "run-case", "3", "4", "7").ok()
    cases = []
    for name in ("case03.h5", "case04.h5", "case07.h5", "caseT.h5"):
        with open_checked(sample.build_dir / name, CASE) as file:
            cases.append(read_case(file))
    with h5py.File(sample.build_dir / "thermal.h5") as t:
        asd, names = t["disturbance/asd"][:], t["disturbance/name"].asstr()[:].tolist()
        hz, kinds = t["frequency"][:], t["disturbance/kind"].asstr()[:].tolist()
    assert network_case_section(cases[:3], [], str) == network_correlation_section(cases[:3]) == []
    (section,) = network_case_section(cases, [], str)
    tables = {b.key: b for b in section.blocks if isinstance(b, Table)}
    of = {
        key: {r.cells[0].label or r.cells[0].text: [c.text for c in r.cells] for r in table.rows}
        for key, table in tables.items()
    }
    worst = {j.output: (j, cases[0].judged[n], cases[1].judged[n]) for n, j in enumerate(cases[3].judged)}
    for label, cells in of["network beside"].items():
        mine, third, _ = worst[label.split(",")[0]]
        assert cells[2] == ratio_text(mine.ratio)
        assert cells[4] == f"{ratio_text(third.ratio)} (case 3)"  # likely; case 4 is not
        assert cells[5] == ratio_text(mine.bound_ratio["maximum"])
    stability = of["network stability"]
    assert set(stability) == set(names)
    for name, cells in stability.items():
        judged = [(j.disturbances, j) for j, *_ in worst.values() if j.disturbances is not None]
        factors = [(d.level_factor[names.index(name)], j) for d, j in judged]
        factor, j = min(factors, key=lambda one: -1.0 if np.isnan(one[0]) else one[0])
        now = asd[names.index(name), np.abs(hz - j.binding_hz).argmin()]
        assert cells[2] == power_text(now, 3)
        assert cells[3] == ("cannot alone" if np.isnan(factor) else ratio_text(factor))
        assert cells[4] == ("" if np.isnan(factor) else power_text(now * factor, 3))
        assert cells[5] == {"temperature": "K/√Hz", "power": "W/√Hz"}[kinds[names.index(name)]]
    with h5py.File(sample.build_dir / "caseT.h5") as case:
        matrix = case["correlation/real"][:] + 1j * case["correlation/imaginary"][:]
        group = case["area/group"].asstr()[:]
        at = np.abs(case["frequency"][:] - 1e-3).argmin()
        level = case["temperature/asd"][:, at][case["temperature/spectrum"][:]]
    (parts,) = network_correlation_section(cases)
    (means,) = (b for b in parts.blocks if isinstance(b, Table))
    table = {(r.cells[0].text, r.cells[1].text): [c.text for c in r.cells] for r in means.rows}
    one, other = (np.flatnonzero(group == g) for g in ("struts", "OB"))
    between = matrix[np.ix_(one, other)]
    pair = next(p for p in (("struts", "OB"), ("OB", "struts")) if p in table)
    assert table[pair][2] == f"{np.abs(between).mean():.2f}"
    assert float(table[pair][3].replace("−", "-")) == pytest.approx(between.real.mean(), abs=0.006)
    assert of["network levels"]["struts"][1] == power_text(np.sqrt(np.mean(level[one] ** 2)), 3)
    assert of["network levels"]["OB"][2] == power_text(1e-4, 3)
    assert {"3", "4"} < set(of["network resemblance"])
    assert "7" not in of["network resemblance"]


def weights_project(folder: Path, small: Project, shipped: str, *, common: bool) -> tuple[Project, str]:
    """Nodes that are areas, but for the last, which no node is for; all at boundaries, one or one each."""
    with h5py.File(small.build_dir / "sensitivity.h5") as file:
        areas = file["area/name"].asstr()[:].tolist()
    *mapped, last = areas
    folder.mkdir()
    with (folder / "weights.csv").open("w", newline="") as lines:
        of = {mapped[0]: "EDGE"} if common else {}  # a boundary that lies on the model
        csv.writer(lines).writerows([("node", "area", "weight"), *((of.get(a, f"N_{a}"), a, 1) for a in mapped)])
    edges = ["EDGE"] if common else [f"EDGE_{a}" for a in mapped]
    with (folder / "nodes.csv").open("w", newline="") as lines:
        nodes = [(f"N_{a}", 1e-9, "diffusive", "") for a in mapped]
        head = ("node", "capacity_J_K", "kind", "temperature_K")
        csv.writer(lines).writerows([head, *nodes, *((edge, 0, "boundary", 293) for edge in edges)])
    with (folder / "conductors.csv").open("w", newline="") as lines:
        links = [(edges[0] if common else f"EDGE_{a}", f"N_{a}", 0.1, 0) for a in mapped]
        csv.writer(lines).writerows([("node_a", "node_b", "GL_W_K", "GR_m2"), *links])
    text = '[network]\nnodes = "nodes.csv"\nconductors = "conductors.csv"\n'
    for edge in edges:
        text += f'[[disturbance]]\nname = "d{edge}"\nnodes = ["{edge}"]\nkind = "temperature"\npreset = "white"\n'
        text += "level_K = 1e-4\n"
    text += f'[map]\nweights = "weights.csv"\nunmapped = ["{last.lower()}"]\n'
    project = project_in(folder, small, text, white(shipped) + CASE_T)
    command(project, "build-thermal").ok()
    return project, last


@pytest.mark.parametrize(("common", "other"), [(True, "1"), (False, "2")])
def test_becomes_the_case_of_areas(small: Project, shipped: str, tmp_path: Path, common: bool, other: str) -> None:
    """Gains of 1 without conductors between: all areas alike, or each alone; the unmapped area is on its own."""
    project, last = weights_project(tmp_path / "p", small, shipped, common=common)
    if common:
        text = project.cases.read_text(encoding="utf-8")
        old = 'blocks = [{ areas = ["*"] }]'
        assert old in text
        with h5py.File(small.build_dir / "sensitivity.h5") as file:
            rest = [a for a in file["area/name"].asstr()[:].tolist() if a != last]
        project.cases.write_text(
            text.replace(old, f'blocks = [{{ areas = {json.dumps(rest)} }}, {{ areas = ["{last}"] }}]')
        )
    command(project, "run-case", "T", other).ok()
    build = project.build_dir
    with h5py.File(build / "caseT.h5") as t, h5py.File(build / f"case0{other}.h5") as case:
        assert t["area/name"].asstr()[-1] == last
        assert t["disturbance/name"].asstr()[-1] == last
        np.testing.assert_allclose(t["verdict/ratio"][:], case["verdict/ratio"][:], rtol=1e-6)
        # By the adjoint, and by a unit load of each area: digits go where areas cancel.
        np.testing.assert_allclose(t["bound_ratio/ratio"][:], case["bound_ratio/ratio"][:], rtol=2e-5)
        for label in (GRAVITY, READ_OUT):
            np.testing.assert_allclose(t[f"psd/{label}"][:], case[f"psd/{label}"][:], rtol=1e-6)
        np.testing.assert_allclose(t["contribution/share"][:], case["contribution/share"][:], rtol=1e-5, atol=1e-9)
        np.testing.assert_allclose(t["improvement/matched"][:], case["improvement/matched"][:], rtol=2e-5)
    shares_on_the_mesh_are_those_of(project, other)


def shares_on_the_mesh_are_those_of(project: Project, other: str) -> None:
    """Nodes that are areas: the same share of every grid as in the case of areas, also of what the map leaves out."""
    import meshio

    mesh = project.build_dir / "m.vtu"
    outputs = ("--of", GRAVITY, "--of", READ_OUT)
    tedm("export-vtu", "--case", "T", "--case", other, *outputs, "-o", mesh, "-d", project.build_dir).ok()
    found = meshio.read(mesh).point_data
    for label in (GRAVITY, READ_OUT):
        share, wanted = (found[f"share_{label}_case{case}"] for case in ("T", other))
        assert abs(wanted.sum() - 1.0) < 0.2  # what is at no grid is small
        np.testing.assert_allclose(share, wanted, rtol=0.0, atol=1e-5 * np.abs(wanted).max())


def changed(path: Path, old: str, new: str) -> None:
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new, 1), encoding="utf-8")


def test_refusals(sample: Project, tmp_path: Path) -> None:
    """One clear error each, and the case file of before stays."""
    shutil.copytree(sample.file.path.parent, tmp_path / "p")
    project = load_project(tmp_path / "p" / "tedm.toml", tmp_path / "p" / "build")
    folder, thermal = tmp_path / "p", tmp_path / "p" / "build" / "thermal.h5"
    changed(folder / "thermal.toml", "level_K = 2e-3", "level_K = 3e-3")
    command(project, "run-case", "T").refused(4, "is stale", hint="build-thermal")
    changed(folder / "thermal.toml", "level_K = 3e-3", "level_K = 2e-3")
    thermal.unlink()
    command(project, "run-case", "T").refused(4, "no such file; case T", hint="build-thermal")
    changed(folder / "cases.toml", "thermal = true", "thermal = true\nrho = 0.5")
    command(project, "run-case", "T").refused(3, "leave rho out")
    changed(folder / "cases.toml", "thermal = true\nrho = 0.5", "thermal = true")
    changed(folder / "tedm.toml", 'thermal = "thermal.toml"\n', "")
    for words in (("run-case", "T"), ("run", "-n"), ("make-rules",)):
        command(project, *words).refused(3, "the project has no thermal model", hint="delete the case")
    gradient = '\n[[temperature.within]]\nareas = ["OB_*"]\nname = "bench"\nacross_K = 1e-4\n'
    with (folder / "tedm.toml").open("a") as file:
        file.write('thermal = "thermal.toml"\n')
    with (folder / "cases.toml").open("a") as file:
        file.write(gradient)
    command(project, "run-case", "T").refused(3, "whose nodes tell gradients")


def test_frequencies_that_the_file_does_not_have(sample: Project, tmp_path: Path) -> None:
    """The network is solved there: the same spectra as with a thermal.h5 that has them."""
    shutil.copytree(sample.file.path.parent, tmp_path / "p")
    project = load_project(tmp_path / "p" / "tedm.toml", tmp_path / "p" / "build")
    changed(tmp_path / "p" / "cases.toml", "points = 301", "points = 40")
    found = []
    for words in ((), ("build-thermal",)):
        if words:
            command(project, *words).ok()
        command(project, "run-case", "T").ok()
        with h5py.File(project.build_dir / "caseT.h5") as case:
            found.append((case[f"psd/{GRAVITY}"][:], case[f"psd/{READ_OUT}"][:], case["frequency"][:]))
            told = case["temperature/model"].asstr()[()]
        assert ("that thermal.h5 does not have" in told) == (not words)
    assert len(found[0][2]) < 50
    for solved, known in zip(*found, strict=True):
        np.testing.assert_allclose(solved, known, rtol=1e-10)


def test_the_chain_makes_it_from_the_network(sample: Project) -> None:
    """run-case and simulate of this case and the figures alone need thermal.h5."""
    steps = chain_of(chain_files(sample))
    network = sample.build_dir / "thermal.h5"
    using = [step.words for step in steps if network in step.inputs]
    assert using == ["run-case T", "simulate T", "plot"]
    words = [step.words for step in steps]
    assert words.index("build-thermal") < words.index("run-case T")


def test_a_complex_matrix_beside_it_is_no_network(sample: Project, tmp_path: Path) -> None:
    """The frequency of a correlation is of the network alone: a matrix with an imaginary part has none."""
    shutil.copytree(sample.file.path.parent, tmp_path / "p")
    project = load_project(tmp_path / "p" / "tedm.toml", tmp_path / "p" / "build")
    with h5py.File(project.build_dir / "caseT.h5") as file:
        assert file["correlation/frequency"][()] == 1e-3
        assert "imaginary" in file["correlation"]
    with h5py.File(project.build_dir / "sensitivity.h5") as file:
        one, other = file["area/name"].asstr()[:2].tolist()
    (tmp_path / "p" / "r.csv").write_text(f"area,{one},{other}\n{one},1,0.5-0.2j\n{other},0.5+0.2j,1\n")
    with (tmp_path / "p" / "cases.toml").open("a") as file:
        file.write('\n[[case]]\nid = "m"\ntitle = "matrix"\nmatrix = "r.csv"\n')
    command(project, "run-case", "m").ok()
    with h5py.File(project.build_dir / "casem.h5") as file:
        assert "frequency" not in file["correlation"]
        assert "imaginary" in file["correlation"]
