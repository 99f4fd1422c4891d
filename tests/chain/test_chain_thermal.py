"""A case of the thermal network on the small sample: by NumPy from the files, and as the cases that it can become."""

from __future__ import annotations

import csv
import json
import re
import shutil
import sys
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest

sys.path.append(str(Path(__file__).parents[1] / "borders"))

from border_tools import Outcome, tedm

from tedm_cli.chain.graph import chain_of
from tedm_cli.config.cases import load_cases
from tedm_cli.config.project import Project, load_project
from tedm_cli.config.temperature_tables import temperature_model
from tedm_cli.contracts import DYNAMICS, SIMULATION
from tedm_cli.files.store import open_checked
from tedm_cli.report.dynamics import loop_detail_section
from tedm_cli.results.dynamics import ClosedLoop, read_closed_loop
from tedm_cli.results.outputs import read_outputs
from tedm_cli.results.thermal_case import thermal_columns
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
    return (ROOT / "configs" / "cases.toml").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def sample(small: Project, shipped: str, tmp_path_factory: pytest.TempPathFactory) -> Project:
    """With the network of the sample; case T was run. Not to be changed."""
    thermal = (SMALL / "thermal.toml").read_text(encoding="utf-8")
    for name in ("nodes", "conductors", "powers", "elements"):
        thermal = thermal.replace(f'"thermal_{name}.csv"', f'"{SMALL}/thermal_{name}.csv"')
    project = project_in(tmp_path_factory.mktemp("network") / "p", small, thermal, shipped + DIFFERENCE + CASE_T)
    command(project, "build-thermal").ok()
    command(project, "run-case", "T").ok()
    return project


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


@pytest.fixture(scope="module")
def looped(sample: Project) -> Project:
    """The same with its drag-free loop, and case T in it."""
    command(sample, "build-dynamics").ok()
    command(sample, "simulate", "T").ok()
    return sample


def test_in_closed_loop_by_numpy_from_the_files(looped: Project) -> None:
    """Cross-spectra of the nodes through the system that dynamics.h5 holds, at frequencies of the network's file."""
    with (
        h5py.File(looped.build_dir / "thermal.h5") as t,
        h5py.File(looped.build_dir / "dynamics.h5") as loop,
        h5py.File(looped.build_dir / "simulationT.h5") as of,
    ):
        free, mapped, labels = (t[p].asstr()[:].tolist() for p in ("node/free_name", "map/node", "row/label"))
        at = [free.index(name) for name in mapped]
        s = dict(zip(labels, t["sensitivity"][:], strict=True))
        a, b, c, d = (loop[f"system/{name}"][:] for name in "ABCD")
        inputs, outputs = (loop[f"system/{name}"].asstr()[:].tolist() for name in ("input", "output"))
        v = np.zeros((len(inputs), len(mapped)), dtype=complex)
        for i, name in enumerate(inputs):
            kind, _, rest = name.partition("_")
            label = {"s": rest, "n": f"A_{rest}", "nddot": f"A_{rest}"}.get(kind)
            v[i] = s.get(label, 0.0)
        assert (v != 0.0).any(axis=1).sum() >= 12 + 6
        f = of["frequency"][:]
        for number in (3, 150, 280):
            hz = t["frequency"][number]
            place = int(np.abs(f - hz).argmin())
            assert f[place] == pytest.approx(hz, rel=1e-9)
            drive = t["transfer"][number][at] * t["disturbance/asd"][:, number]
            h = c @ np.linalg.solve(2j * np.pi * hz * np.eye(len(a)) - a, b) + d
            temperatures = drive @ t["disturbance/correlation"][:] @ drive.conj().T
            twice = np.array([name.startswith("nddot_") for name in inputs])[:, None]
            driving = np.where(twice, (2j * np.pi * hz) ** 2, 1.0) * v
            power = np.diag(h @ driving @ temperatures @ driving.conj().T @ h.conj().T).real
            for name in ("TM1_x", "TM2_a_x", "TM1_phi", "delta_g"):
                found = of[f"contribution/thermal/{name}"][place]
                assert found == pytest.approx(power[outputs.index(name)], rel=1e-6), name
        assert of["area/name"].asstr()[:].tolist() == mapped
        share = of["verdict/disturbance_share"][:].sum(axis=1)
        np.testing.assert_allclose(share, of["verdict/group_share"][:, -1], rtol=1e-9)
        assert of["group/name"].asstr()[-1] == "thermal"


def test_printed_and_read_by_others(sample: Project, tmp_path: Path) -> None:
    """-v names disturbances and what each may be; --json too; what cannot take it says so."""
    out = command(sample, "run-case", "T", "-v", "-o", tmp_path / "t.h5").ok().out
    assert "disturbances: electronics_1 " in out
    assert "level of a disturbance that just meets it: panel_minus_x x " in out
    assert re.search(r"correlation of case T at 1 mHz: case \w+ resembles it best", out)
    assert "uncertain of it are levels of disturbances alone" in out
    told = json.loads(command(sample, "run-case", "T", "-v", "--json", "-o", tmp_path / "t.h5").ok().out)
    (one,) = told["cases"] if isinstance(told, dict) else told
    assert "1" in one["deviation_from_case"]
    assert "7" not in one["deviation_from_case"]  # diagnostic
    assert sum(one["sensitivity"][0]["disturbance_share"].values()) == pytest.approx(1.0)
    assert "temperatures of the thermal network" in command(sample, "explain", "T").ok().out
    tedm("show", sample.build_dir / "caseT.h5").ok()
    build = ("-d", sample.build_dir)
    tedm("export-case", "T", "--format", "csv", "-o", tmp_path / "csv", *build).ok()
    tedm("export-extremal", "T", "-o", tmp_path / "e", *build).refused(2, "thermal nodes in place of areas")
    mesh = tmp_path / "mesh.vtu"
    tedm("export-vtu", "--case", "T", "-o", mesh, *build).refused(2, "the displacements on the mesh are of areas")
    tedm("export-vtu", "-o", mesh, *build).ok()  # of nothing: the only verdicts are of thermal nodes
    assert mesh.exists()
    system = command(sample, "export-state-space", "T", "--json", "-o", tmp_path / "system").ok()
    told = json.loads(system.out)
    (made,) = told if isinstance(told, list) else told["cases"]
    assert made["states"] > 60
    assert made["output_deviation"] < 1e-3


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


@pytest.mark.parametrize("which", ["sample", "weights"])
def test_gains_at_any_frequency_and_as_a_system(
    which: str, sample: Project, small: Project, shipped: str, tmp_path: Path
) -> None:
    """By the network that thermal.h5 holds, at its own frequencies; with areas and boundaries of the map."""
    project = sample if which == "sample" else weights_project(tmp_path / "p", small, shipped, common=True)[0]
    config, outputs = load_cases(project.cases)[1], read_outputs(project)
    temperature = temperature_model(project, config, outputs.areas)
    noise = thermal_columns(project, config, "T", outputs, temperature).noise
    assert noise.network is not None
    f = noise.frequency_hz[3::60]
    known = noise.driven[:, 3::60]
    size = np.abs(known).max(axis=(0, 1)) + 1e-300
    np.testing.assert_allclose(noise.network.driven(f) / size, known / size, rtol=1e-9, atol=1e-13)
    between = np.sort(np.append(f, 1.2345e-3))
    there = noise.at(between)
    np.testing.assert_array_equal(np.delete(there.driven, np.searchsorted(between, 1.2345e-3), axis=1), known)
    s = noise.network.system("case T")
    for number, hz in enumerate(f):
        gain = s.c @ np.linalg.solve(2j * np.pi * hz * np.eye(len(s.a)) - s.a, s.b) + s.d
        driven = gain * np.array([spectrum.amplitude(f[[number]])[0] for spectrum in s.spectra])
        np.testing.assert_allclose(driven / size, known[:, number] / size, rtol=1e-8, atol=1e-12)
    assert len(noise.disturbances) == len(s.spectra) >= 2


def test_temperatures_that_go_with_an_output(sample: Project, tmp_path: Path) -> None:
    """On the grids: they make one amplitude of it, each disturbance its part of the power; in files and in a figure."""
    out, field = tmp_path / "field.h5", tmp_path / "field.png"
    told = command(sample, "map-temperatures", "--case", "T", "--of", READ_OUT, "-o", out, "--figure", field).ok()
    assert f"one amplitude of {READ_OUT} in case T at" in told.out
    assert field.stat().st_size > 10_000
    with h5py.File(sample.build_dir / "caseT.h5") as case, h5py.File(out) as of:
        with h5py.File(sample.build_dir / "thermal.h5") as t:
            row = t["sensitivity"][t["row/label"].asstr()[:].tolist().index(READ_OUT)]
            assert t["map/node"].asstr()[:].tolist() == of["map/node"].asstr()[:].tolist()
        o = case["output/label"].asstr()[:].tolist().index(READ_OUT)
        at = np.abs(case["frequency"][:] - case["contribution/frequency"][o]).argmin()
        asd = np.sqrt(case[f"psd/{READ_OUT}"][at])
        made = of["given"][:] @ row
        names = of["set/name"].asstr()[:].tolist()
        assert names == ["typical", *case["disturbance/name"].asstr()[:]]
        np.testing.assert_allclose(made[0], asd, rtol=1e-9)
        np.testing.assert_allclose(made[1:] / asd, case["disturbance/share"][o], rtol=1e-6, atol=1e-12)
        assert np.isfinite(of["temperature"][:]).all()
    for args, fact in (
        ((), "give a FILE or --case, found neither"),
        (("tau.csv", "--case", "T"), "found both"),
        (("tau.csv", "--of", READ_OUT), "--of is of --case"),
        (("--case", "T", "--of", "A_TM3_x"), "no output of caseT.h5 is called 'A_TM3_x'"),
        (("--case", "3"), "case 3 is of areas"),
    ):
        command(sample, "map-temperatures", *args).refused(2, fact)


def changed(path: Path, old: str, new: str) -> None:
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new, 1), encoding="utf-8")


def test_refusals(sample: Project, tmp_path: Path) -> None:
    """One clear error each, and the case file of before stays."""
    shutil.copytree(sample.file.path.parent, tmp_path / "p")
    project = load_project(tmp_path / "p" / "tedm.toml", tmp_path / "p" / "build")
    folder, thermal = tmp_path / "p", tmp_path / "p" / "build" / "thermal.h5"
    changed(folder / "cases.toml", "points = 301", "points = 300")
    command(project, "run-case", "T").refused(4, "has no gains at", hint="leave [frequency] out")
    changed(folder / "cases.toml", "points = 300", "points = 301")
    changed(folder / "thermal.toml", "level_K = 2e-3", "level_K = 3e-3")
    command(project, "run-case", "T").refused(4, "is stale", hint="build-thermal")
    changed(folder / "thermal.toml", "level_K = 3e-3", "level_K = 2e-3")
    thermal.unlink()
    command(project, "run-case", "T").refused(4, "no such file; case T", hint="build-thermal")
    changed(folder / "cases.toml", "thermal = true", "thermal = true\nrho = 0.5")
    command(project, "run-case", "T").refused(3, "leave rho out")
    changed(folder / "cases.toml", "thermal = true\nrho = 0.5", "thermal = true")
    changed(folder / "tedm.toml", 'thermal = "thermal.toml"\n', "")
    command(project, "run-case", "T").refused(3, "the project has no thermal model")
    gradient = '\n[[temperature.within]]\nareas = ["OB_*"]\nname = "bench"\nacross_K = 1e-4\n'
    with (folder / "tedm.toml").open("a") as file:
        file.write('thermal = "thermal.toml"\n')
    with (folder / "cases.toml").open("a") as file:
        file.write(gradient)
    command(project, "run-case", "T").refused(3, "whose nodes tell gradients")


QUIET = """
[noise]
preset = "none"

[time]
rate_hz = 0.2
samples = 30000

[[requirement]]
name = "lpf_acceleration"
outputs = ["delta_g"]
applies_to = "differential"
"""


def test_realised_in_closed_loop(looped: Project, tmp_path: Path) -> None:
    """The network as a system behind the filters of its disturbances, ahead of a loop that is quiet but for them."""
    shutil.copytree(looped.file.path.parent, tmp_path / "p")
    project = load_project(tmp_path / "p" / "tedm.toml", tmp_path / "p" / "build")
    (tmp_path / "p" / "dynamics.toml").write_text(QUIET)
    with project.file.path.open("a") as file:
        file.write('dynamics = "dynamics.toml"\n')
    command(project, "build-dynamics").ok()
    out = command(project, "simulate", "T", "--time").ok().out
    assert "delta_g  lpf_acceleration" in out
    assert "thermal 100 %" in out
    with h5py.File(project.build_dir / "simulationT.h5") as of:
        ratio = of["realisation/psd"][:] / of["realisation/exact"][:]
        # Averages of chi-square over bins: 30 segments' worth of data at the lowest frequency, more above.
        assert ratio.mean() == pytest.approx(1.0, abs=0.08)
        assert (of["realisation/exact"][:] > 0.0).all()


def test_the_report_tells_disturbances_where_they_are_heard(looped: Project) -> None:
    """In the noise of the sample's loop they are not; with a quiet loop there would be a table of each output."""
    with (
        open_checked(looped.build_dir / "dynamics.h5", DYNAMICS) as dynamics,
        open_checked(looped.build_dir / "simulationT.h5", SIMULATION) as file,
    ):
        found = read_closed_loop(dynamics, [file])
    assert found is not None
    (case,) = found.cases

    def told(loop: ClosedLoop) -> str:
        return repr(loop_detail_section(loop, ["T"], [], [], str))

    assert "make at most a thousandth of the noise" in told(found)
    shares = {name: 0.5 / (n + 1) for n, name in enumerate(case.judged[0].disturbance_share)}
    heard = replace(found, cases=(replace(case, judged=(replace(case.judged[0], disturbance_share=shares),)),))
    text = told(heard)
    assert "by disturbance of the thermal network" in text
    assert "at most" not in text.partition("by disturbance of the thermal network")[0]
    assert text.index("panel_minus_x") < text.index("photodiodes")


UNCERTAIN = """
[[uncertainty.disturbance]]
name = "electronics"
disturbances = ["electronics_*", "photodiodes"]
relative_sigma = 1.5
distribution = "lognormal"
source = "a test"

[[uncertainty.level]]
name = "everywhere"
areas = ["*"]
relative_sigma = 0.1
source = "a test"
"""


def test_levels_of_disturbances_are_uncertain(sample: Project, tmp_path: Path) -> None:
    """Probabilities of case T by its disturbances, of others by areas; each says what is left out of it."""
    shutil.copytree(sample.file.path.parent, tmp_path / "p")
    project = load_project(tmp_path / "p" / "tedm.toml", tmp_path / "p" / "build")
    changed(project.cases, "samples = 10000", "samples = 1000")
    with project.cases.open("a") as file:
        file.write(UNCERTAIN)
    out = command(project, "run-case", "T", "1").ok().out
    assert "everywhere in case T: levels of areas, where temperatures follow disturbances" in out
    with h5py.File(project.build_dir / "caseT.h5") as t, h5py.File(project.build_dir / "case01.h5") as case:
        assert t["uncertainty/parameter/name"].asstr()[:].tolist() == ["electronics"]
        assert "everywhere" in case["uncertainty/parameter/name"].asstr()[:]
        assert "electronics" not in case["uncertainty/parameter/name"].asstr()[:]
        spread = t["uncertainty/quantile"][:, 94] / t["uncertainty/quantile"][:, 49]
        assert (spread > 1.5).any(), "they make most of the read-outs"
        assert (spread >= 1.0).all()
    text = project.cases.read_text(encoding="utf-8")
    project.cases.write_text(text.replace('"electronics_*"', '"electronix_*"'))
    fact = "uncertainty.disturbance[0].disturbances: no disturbance matches 'electronix_*'; there are"
    command(project, "run-case", "T").refused(3, fact)
    project.cases.write_text(text.replace("thermal = true", 'blocks = [{ areas = ["*"] }]'))
    command(project, "run-case", "1").refused(3, "no case is of the thermal network")


def test_the_chain_makes_it_from_the_network(sample: Project) -> None:
    """run-case and simulate of this case alone need thermal.h5."""
    steps = chain_of(chain_files(sample))
    network = sample.build_dir / "thermal.h5"
    using = [step.words for step in steps if network in step.inputs]
    assert using == ["run-case T", "simulate T"]
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
