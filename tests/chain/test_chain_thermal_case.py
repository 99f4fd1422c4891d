"""A case of the thermal network beyond its spectra: in closed loop, in time, on the model, and how sure it is."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest
from shipped_cases import cases_of_areas
from test_chain_thermal import READ_OUT, changed, command, network_case, weights_project

from tedm_cli.config.cases import load_cases
from tedm_cli.config.project import Project, load_project
from tedm_cli.config.temperature.tables import temperature_model
from tedm_cli.contracts import DYNAMICS, SIMULATION
from tedm_cli.files.store import open_checked
from tedm_cli.report.dynamics import loop_detail_section
from tedm_cli.results.dynamics.loop import ClosedLoop, read_closed_loop
from tedm_cli.results.outputs import read_outputs
from tedm_cli.results.thermal.case import thermal_columns


def copied(project: Project, folder: Path) -> Project:
    """A copy that may be changed."""
    shutil.copytree(project.file.path.parent, folder / "p")
    return load_project(folder / "p" / "tedm.toml", folder / "p" / "build")


@pytest.fixture(scope="module")
def shipped() -> str:
    return cases_of_areas()


@pytest.fixture(scope="module")
def sample(small: Project, shipped: str, tmp_path_factory: pytest.TempPathFactory) -> Project:
    return network_case(small, shipped, tmp_path_factory)


@pytest.fixture(scope="module")
def looped(sample: Project, tmp_path_factory: pytest.TempPathFactory) -> Project:
    """A copy with its drag-free loop, and case T in it. Not to be changed."""
    project = copied(sample, tmp_path_factory.mktemp("looped"))
    command(project, "build-dynamics").ok()
    command(project, "simulate", "T").ok()
    return project


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
    s = noise.network.linear_system("case T")
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
    project = copied(looped, tmp_path)
    (project.file.path.parent / "dynamics.toml").write_text(QUIET)
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
    project = copied(sample, tmp_path)
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
