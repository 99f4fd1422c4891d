"""simulate --series: what temperatures in time make of the loop, against its exact spectra, and what is refused."""

from __future__ import annotations

import json
import tracemalloc
from pathlib import Path

import h5py
import numpy as np
import pytest
from border_tools import Project, replace, tedm, untouched
from scipy import signal

from tedm_cli.config.project import load_project
from tedm_cli.contracts import DYNAMICS, SIMULATED_SERIES
from tedm_cli.dynamics import steps
from tedm_cli.dynamics.closed_loop import responses
from tedm_cli.dynamics.controller import ScalarLoops, default_loops
from tedm_cli.dynamics.loops import Loop
from tedm_cli.dynamics.signals import COORDINATES, INPUTS, OUTPUTS
from tedm_cli.files.store import open_checked
from tedm_cli.stages import temperature_series
from tedm_cli.stages.dynamics.loop import project_loop
from tedm_cli.tables import wide_table

SERIES = '\n[[series]]\nname = "{name}"\nfile = "{name}.h5"\nremove = "{remove}"\n{more}'
FAST = '[[requirement]]\nname = "lpf_acceleration"\noutputs = ["delta_g"]\napplies_to = "differential"\n'


def configure(project: Project, name: str, remove: str = "nothing", more: str = "", dynamics: str = FAST) -> None:
    with open(project.folder / "cases.toml", "a") as stream:
        stream.write(SERIES.format(name=name, remove=remove, more=more))
    (project.folder / "dynamics.toml").write_text(dynamics)
    project.run("build-dynamics", "-q").ok()


def write(project: Project, name: str, step_s: float, **columns: np.ndarray) -> None:
    with h5py.File(project.folder / f"{name}.h5", "w") as file:
        file["time_s"] = step_s * np.arange(len(next(iter(columns.values()))))
        for column, values in columns.items():
            file[column] = values


def held(path: Path) -> dict[str, np.ndarray]:
    found: dict[str, np.ndarray] = {}
    with h5py.File(path) as file:
        file.visititems(lambda name, item: found.update({name: item[()]} if isinstance(item, h5py.Dataset) else {}))
    return found


def test_a_sinusoid_of_temperature(satellite: Project) -> None:
    """|H V| of the exact frequency response to 1e-6, with what straight lines between samples make of a sinusoid."""
    f, step_s, rows = 2e-3, 4.0, 45_000
    t = step_s * np.arange(rows)
    write(satellite, "sine", step_s, all=np.sin(2 * np.pi * f * t))
    configure(satellite, "sine", more="lowest_hz = 1e-3\n")
    satellite.run("simulate", "--series", "sine", "-q").ok()
    found = held(satellite.build / "simulation_sine.h5")
    labels = [name.decode() for name in found["output/label"]]
    assert set(labels) == {"delta_g", "delta_g_full", "TM1_x"}
    loop = project_loop(load_project(satellite.folder / "tedm.toml", satellite.build))
    with open_checked(satellite.build / "dynamics.h5", DYNAMICS) as file:
        v = file.array(DYNAMICS.THERMAL_V).sum(axis=1)
    of = {"series": v, "gravity/series": v * (np.arange(45) >= 33), "read_out/series": v * (np.arange(45) < 33)}
    nu = np.append(f + np.arange(-60, 61) / step_s, f + 1e7)
    h = np.concatenate([x for _, x in responses(loop.plant, loop.controller, np.abs(nu), difference_s=step_s)])
    h = np.where((nu < 0)[:, None, None], h.conj(), h)
    period = round(1.0 / f / step_s)
    tail = slice(-20 * period, None)
    np.testing.assert_allclose(found["time"], t[1:-1])
    wave = np.exp(2j * np.pi * f * found["time"][tail])
    for family, column in of.items():
        made = h[:, [OUTPUTS.index(name) for name in labels]] @ column
        direct = made[-1]  # what does not fall with frequency
        wanted = direct + np.sinc(nu[:-1] * step_s) ** 2 @ (made[:-1] - direct)
        got = [2j * np.mean(found[f"{family}/{name}"][tail] * wave.conj()) for name in labels]
        size = np.abs(h[60, [OUTPUTS.index(name) for name in labels]] @ of["series"])
        np.testing.assert_allclose(np.array(got) / size, wanted / size, atol=1e-6)
    np.testing.assert_allclose(
        found["series/delta_g"], found["gravity/series/delta_g"] + found["read_out/series/delta_g"]
    )


def test_white_noise_is_what_the_exact_case_expects(satellite: Project) -> None:
    """All areas move as one: the part of the temperatures of case 1 with the preset white, apart and together."""
    level, step_s, rows = 1e-4, 4.0, 60_000
    noise = level * np.sqrt(0.5 / step_s) * np.random.default_rng(2).normal(size=rows)
    write(satellite, "white", step_s, all=noise)
    cases = satellite.folder / "cases.toml"
    replace(cases, 'preset = "thesis"', 'preset = "white"')
    replace(cases, "outside_K = 1e-3", f"outside_K = {level}")
    for line in ("reference_hz = 1e-3\n", "order = 2\n", "corner_hz = 1e-3\n"):
        replace(cases, line, "")
    configure(satellite, "white", more="lowest_hz = 1e-3\n")
    (said,) = json.loads(satellite.run("simulate", "--series", "white", "--json").ok().out)
    satellite.run("simulate", "1", "-q").ok()
    exact, found = held(satellite.build / "simulation01.h5"), held(satellite.build / "simulation_white.h5")
    f = found["frequency"]
    inside = (f > 1e-3) & (f < 0.01)  # above, straight lines between samples are not a sinusoid
    for name in ("delta_g", "delta_g_full", "TM1_x"):
        for made, wanted in (("psd", "contribution/thermal"), ("gravity/psd", "thermal/gravity")):
            expected = np.exp(np.interp(np.log(f), np.log(exact["frequency"]), np.log(exact[f"{wanted}/{name}"])))
            ratio = found[f"{made}/{name}"][inside] / expected[inside]
            assert abs(ratio.mean() - 1.0) < 0.08, (name, made, ratio.mean())
            assert np.all((ratio > 0.3) & (ratio < 2.5)), (name, made)
    assert said["verdicts"][0]["output"] == "delta_g"
    assert said["verdicts"][0]["ratio"] == found["verdict/ratio"][0]
    with open_checked(satellite.build / "simulation_white.h5", SIMULATED_SERIES):
        pass
    assert "simulation_white.h5 (simulated_series): up to date" in tedm("check", "-d", satellite.build).out


def test_blocks_make_no_difference_and_memory_does_not_grow(
    satellite: Project, monkeypatch: pytest.MonkeyPatch
) -> None:
    rng = np.random.default_rng(3)
    for name, rows in (("short", 4_000), ("long", 12_000)):
        write(satellite, name, 4.0, outside=293.0 + rng.normal(size=rows), inside=293.0 + rng.normal(size=rows))
    configure(satellite, "short", "linear", "lowest_hz = 2e-2\n")
    configure(satellite, "long", "linear", "lowest_hz = 2e-2\n")
    satellite.run("simulate", "--series", "short", "-q").ok()
    before = held(satellite.build / "simulation_short.h5")
    monkeypatch.setattr(steps, "_BLOCK", 497)
    monkeypatch.setattr(temperature_series, "_BLOCK_SAMPLES", 613)
    monkeypatch.setattr(wide_table, "BLOCK_NUMBERS", 3 * 577)
    peak = []
    for name in ("short", "long"):
        tracemalloc.start()
        satellite.run("simulate", "--series", name, "-q").ok()
        peak.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peak[1] - peak[0] < 3e5, "8,000 samples of 15 outputs are 1 MB"
    after = held(satellite.build / "simulation_short.h5")
    for name in before:
        if "series/" in name or "psd/" in name:
            scale = np.abs(before[name]).max()
            np.testing.assert_allclose(after[name] / scale, before[name] / scale, atol=1e-11, err_msg=name)


def sampled(project: Project, dt_s: float) -> str:
    """The default loops without their delays, sampled, in own.npz; the configuration that names it."""
    loop = project_loop(load_project(project.folder / "tedm.toml", project.build))
    s = ScalarLoops(loop.plant, [Loop(x.name, x.crossover_hz, 0.0) for x in default_loops()]).state_space()
    a, b, c, d, _ = signal.cont2discrete((s.a, s.b, -s.c, -s.d), dt_s, "bilinear")
    names = {"inputs": np.array(COORDINATES), "outputs": np.array(INPUTS)}
    np.savez(project.folder / "own.npz", A=a, B=b, C=c, D=d, dt_s=dt_s, delay_s=0.2, **names)
    return f'[controller]\nfile = "own.npz"\n[noise]\nomit = ["capacitive"]\n{FAST}'


def test_a_sampled_controller_through_the_commands(satellite: Project) -> None:
    """build-dynamics, simulate, --time, --series and export-state-space; its loop comes to the continuous one."""
    write(satellite, "walk", 4.0, all=np.cumsum(np.random.default_rng(4).normal(size=9_000)))
    configure(satellite, "walk", "mean", "lowest_hz = 5e-3\n")
    satellite.run("simulate", "--series", "walk", "-q").ok()
    continuous = held(satellite.build / "simulation_walk.h5")
    own = sampled(satellite, 0.2)
    (satellite.folder / "dynamics.toml").write_text(own + "[time]\nsamples = 16384\n")
    satellite.run("build-dynamics").ok()
    with h5py.File(satellite.build / "dynamics.h5") as file:
        assert (file["controller/period"][()], file["controller/delay"][()]) == (0.2, 0.2)
        assert "system" not in file
    satellite.run("simulate", "3", "--time").ok()
    r = held(satellite.build / "simulation03.h5")
    mean = (r["realisation/psd"] / r["realisation/exact"]).mean(axis=1)
    assert np.abs(mean - 1.0).max() < 0.01 + 6.0 / np.sqrt(r["realisation/degrees_of_freedom"].sum() / 2.0)
    satellite.run("simulate", "--series", "walk", "-q").ok()
    found = held(satellite.build / "simulation_walk.h5")
    for name in ("delta_g", "TM1_x"):
        f = found["frequency"]
        ratio = found[f"psd/{name}"] / continuous[f"psd/{name}"]
        np.testing.assert_allclose(ratio[f < 0.02], 1.0, atol=0.05, err_msg=name)
    satellite.run("export-state-space", "3", "--loop").refused(4, "sampled")


def test_samples_that_do_not_fit_a_sampled_controller(satellite: Project) -> None:
    write(satellite, "walk", 4.0, all=np.arange(9_000.0))
    configure(satellite, "walk", "mean", "lowest_hz = 5e-3\n")
    (satellite.folder / "dynamics.toml").write_text(sampled(satellite, 0.3))
    satellite.run("build-dynamics").ok()
    with untouched(satellite.folder):
        done = satellite.run("simulate", "3", "--time")
        done.refused(
            4, "dynamics.toml", "time.rate_hz", "no whole number of the controller's periods of 0.3 s", hint="2.1 s"
        )
        done = satellite.run("simulate", "--series", "walk")
        done.refused(4, "cases.toml: series walk", "samples of 4 s are no whole number", hint="3.9 s")


def test_a_short_series_is_judged_in_what_its_spectrum_has(satellite: Project) -> None:
    """A tone at 20 mHz in 8,000 s, whose spectrum begins at some 8 mHz: it fails there, by Δg, and the rest is said."""
    time = 4.0 * np.arange(2002)
    write(satellite, "short", 4.0, all=5.0 * np.sin(2 * np.pi * 20e-3 * time))
    configure(satellite, "short", "mean")
    done = satellite.run("simulate", "--series", "short", "--fail-on-violation")
    done.refused(5, "requirements are violated in series short")
    assert "FAIL in part" in done.out
    assert "delta_g: lpf_acceleration over 0.001 to 0.008 Hz, below the estimate" in done.out
    with h5py.File(satellite.build / "simulation_short.h5") as file:
        outputs = list(file["verdict/output"].asstr())
        v = outputs.index("delta_g")
        assert file["verdict/lowest"][v] == pytest.approx(8e-3)
        assert not file["verdict/whole_band"][v]
        assert file["verdict/binding_frequency"][v] == pytest.approx(20e-3, rel=0.02)
        assert file["verdict/band_rms"][v] == pytest.approx(file["series/delta_g"][500:-500].std(), rel=0.05)


def test_series_that_are_refused(satellite: Project, tmp_path: Path) -> None:
    write(satellite, "warm", 4.0, all=np.ones(200))
    configure(satellite, "warm", "mean", "lowest_hz = 1e-3\n")
    write(satellite, "fine", 4.0, all=np.cumsum(np.ones(9_000)))
    configure(satellite, "fine", "linear", "lowest_hz = 5e-3\n")
    with untouched(satellite.folder):
        satellite.run("simulate", "--series", "worm").refused(2, "no series 'worm'", hint="did you mean warm?")
        satellite.run("simulate", "3", "--series", "warm").refused(2, "takes no case")
        satellite.run("simulate", "--series", "warm", "--time").refused(2, "takes no --time")
        satellite.run("simulate", "--series", "all", "-o", tmp_path / "x.h5").refused(2, "--output names one file")
        satellite.run("simulate", "--series", "warm").refused(4, "warm.h5", "too few for a spectrum from 0.001 Hz")
    satellite.run("simulate", "--series", "all").refused(4, "warm.h5", "too few")
    assert (satellite.build / "simulation_fine.h5").is_file(), "one that is refused keeps no other from being run"
    (satellite.build / "dynamics.h5").unlink()
    satellite.run("simulate", "--series", "fine").refused(4, "dynamics.h5: no such file", hint="tedm build-dynamics")


def test_a_series_by_the_name_of_a_case_file(satellite: Project) -> None:
    text = '\n[[case]]\nid = "_warm"\ntitle = "x"\nblocks = [{ areas = ["*"] }]\n'
    with open(satellite.folder / "cases.toml", "a") as stream:
        stream.write(text + SERIES.format(name="warm", remove="mean", more=""))
    satellite.run("simulate", "--series", "warm").refused(3, "series[0].name", "the case id '_warm'")


def test_frequencies_that_miss_the_band_of_the_loop(satellite: Project) -> None:
    """The grid is of the cases file, the band of a requirement of the loop: both are named."""
    configure(satellite, "warm", dynamics='[[requirement]]\nname = "lisa_acceleration"\noutputs = ["TM1_a_x"]\n')
    replace(satellite.folder / "cases.toml", "min_hz = 1e-4", "min_hz = 5e-4")
    satellite.run("simulate", "3").refused(3, "cases.toml: frequency", "does not hold the band", hint="dynamics.toml")
