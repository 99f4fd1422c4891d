"""Temperature series and tables of spectra from users' files: the same numbers from CSV and HDF5, and every refusal."""

from __future__ import annotations

import json
import sys
import tracemalloc
from pathlib import Path

import h5py
import numpy as np
import pytest
from border_tools import Project, replace, snapshot, tedm
from scipy.integrate import trapezoid

from tedm_cli.noise.spectral_estimate import Estimate
from tedm_cli.quantities import TEMPERATURE, TIME_STAMP
from tedm_cli.tables import wide_table
from tedm_cli.tables.wide_table import open_wide

STEP, ROWS = 4.0, 17_000
SERIES = '\n[[series]]\nname = "test"\nfile = "{file}"\nremove = "{remove}"\n{more}'


@pytest.fixture(scope="module")
def temperature() -> np.ndarray:
    """[ROWS, 3]: room temperature, a drift, and fluctuations, for the columns outside, inside, STRUT_1."""
    rng = np.random.default_rng(1)
    drift = np.outer(np.arange(ROWS), [1e-7, -3e-8, 2e-7])
    return 293.0 + drift + 1e-4 * rng.normal(size=(ROWS, 3))


def table(temperature: np.ndarray, rows: int = ROWS) -> dict[str, np.ndarray]:
    names = ("outside", "inside", "STRUT_1")
    return {"time_s": 100.0 + STEP * np.arange(rows), **{n: temperature[:rows, c] for c, n in enumerate(names)}}


def write_csv(path: Path, columns: dict[str, np.ndarray]) -> None:
    np.savetxt(
        path, np.column_stack(list(columns.values())), "%.17g", ",", header=",".join(columns), comments="", newline="\n"
    )


def write_hdf5(path: Path, columns: dict[str, np.ndarray]) -> None:
    with h5py.File(path, "w") as file:
        for name, values in columns.items():
            file[name] = values


def configure(project: Project, file: str = "t.csv", remove: str = "mean", more: str = "") -> None:
    with open(project.folder / "cases.toml", "a") as stream:
        stream.write(SERIES.format(file=file, remove=remove, more=more))


def matrices(project: Project) -> tuple[np.ndarray, list[str], list[str]]:
    """Rows [24, k] in the order of the outputs, and names and shields of the areas."""
    with h5py.File(project.build / "sensitivity.h5") as s, h5py.File(project.build / "optics.h5") as o:
        rows = [s["S"][()], *(o[f"N/{n}"][()] for n in o["set/name"].asstr()[()])]
        return np.concatenate(rows), list(s["area/name"].asstr()), list(s["area/shield"].asstr())


def result(project: Project) -> tuple[np.ndarray, h5py.File]:
    file = h5py.File(project.build / "series_test.h5")
    return np.stack([file[f"series/{label}"][()] for label in file["output/label"].asstr()]), file


@pytest.mark.parametrize("remove", ["nothing", "mean", "linear"])
def test_series_are_the_direct_product(small: Project, temperature: np.ndarray, remove: str) -> None:
    columns = table(temperature)
    write_csv(small.folder / "t.csv", columns)
    configure(small, remove=remove)
    small.run("run-series", "test").ok()
    rows, names, shields = matrices(small)
    areas = np.stack([columns["STRUT_1" if n == "STRUT_1" else s] for n, s in zip(names, shields, strict=True)])
    number = np.arange(ROWS)
    if remove == "mean":
        areas = areas - areas.mean(axis=1, keepdims=True)
    elif remove == "linear":
        areas = areas - areas[:, :1]  # polyfit's rounding grows with what it fits
        slope, start = np.polyfit(number - ROWS / 2, areas.T, 1)
        areas = areas - start[:, None] - slope[:, None] * (number - ROWS / 2)
    found, file = result(small)
    with file:
        size = np.abs(rows) @ np.abs(areas).max(axis=1)
        assert np.all(np.abs(found - rows @ areas).max(axis=1) <= 1e-10 * size)
        np.testing.assert_allclose(file["time"][()], columns["time_s"], rtol=1e-14)
        np.testing.assert_allclose(file["output/rms"][()], np.sqrt(np.mean(found**2, axis=1)), rtol=1e-12)
        np.testing.assert_allclose(file["output/peak"][()], np.abs(found).max(axis=1), rtol=1e-12)
        assert file["temperature/column"].asstr()[names.index("STRUT_1")] == "STRUT_1"
    assert "series_test.h5 (series): up to date" in tedm("check", "-d", small.build).out


def test_csv_and_hdf5_give_the_same_file(
    small: Project, temperature: np.ndarray, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(wide_table, "BLOCK_NUMBERS", 4 * 777)  # blocks that end anywhere
    columns = table(temperature)
    write_csv(small.folder / "t.csv", columns)
    write_hdf5(small.folder / "t.h5", {name: columns[name] for name in ("inside", "STRUT_1", "time_s", "outside")})
    configure(small, more='resample_s = 6.0\nmethod = "polyphase"\n')
    small.run("run-series", "test").ok()
    first, file = result(small)
    file.close()
    replace(small.folder / "cases.toml", '"t.csv"', '"t.h5"')
    small.run("run-series", "test").ok()
    second, file = result(small)
    file.close()
    np.testing.assert_allclose(second, first, rtol=1e-9, atol=1e-12 * np.abs(first).max())
    assert first.shape[1] == len(range(int(np.ceil(24 * 6 / 6)), int((ROWS - 1) * 4 / 6 - 24) + 1))


def test_white_noise_is_judged_as_the_exact_case_judges_it(small: Project) -> None:
    """All areas move as one with white noise: band rms and spectrum against case 1 with the preset white."""
    level, rows = 1e-4, 60_000
    series = level * np.sqrt(0.5 / STEP) * np.random.default_rng(2).normal(size=rows)
    write_hdf5(small.folder / "t.h5", {"time_s": STEP * np.arange(rows), "all": series})
    configure(small, "t.h5")
    replace(
        small.folder / "cases.toml", 'preset = "thesis"', f'preset = "white"\noutside_K = {level}\ninside_K = {level}'
    )
    text = (small.folder / "cases.toml").read_text()
    keep = [
        s
        for s in text.splitlines()
        if not s.startswith(("order =", "corner_hz", "reference_hz", "outside_K = 1e-3", "inside_K = 1e-4 "))
    ]
    (small.folder / "cases.toml").write_text("\n".join(keep))
    found = json.loads(small.run("run-series", "test", "--json").ok().out)[0]
    small.run("run-case", "1").ok()
    with h5py.File(small.build / "case01.h5") as case, h5py.File(small.build / "series_test.h5") as file:
        f = case["frequency"][()]
        band = (f >= 1e-3) & (f <= 30e-3)
        for verdict in found["verdicts"]:
            psd = case[f"psd/{verdict['output']}"][band]
            exact = np.sqrt(trapezoid(psd, f[band]))
            assert verdict["band_rms"] == pytest.approx(exact, rel=0.03, abs=0)
        nu = file["degrees_of_freedom"][0]
        estimate = file["psd/A_TM2_x"][()]
        assert estimate.mean() == pytest.approx(
            psd[0] if verdict["output"] == "A_TM2_x" else case["psd/A_TM2_x"][5], rel=0.02
        )
        assert estimate.std() / estimate.mean() == pytest.approx(np.sqrt(2 / nu), rel=0.1)


def test_differences_that_requirements_judge_are_outputs(small: Project) -> None:
    step = np.arange(ROWS)
    write_hdf5(small.folder / "t.h5", {"time_s": STEP * step, "all": np.sin(0.01 * step)})
    configure(small, "t.h5")
    text = (small.folder / "cases.toml").read_text()
    (small.folder / "cases.toml").write_text(
        text
        + '\n[[requirement]]\nname = "lpf_acceleration"\noutputs = ["TM1_a_x-TM2_a_x"]\napplies_to = "differential"\n'
    )
    found = json.loads(small.run("run-series", "test", "--json").ok().out)[0]
    assert "TM1_a_x-TM2_a_x" in {v["output"] for v in found["verdicts"]}
    with h5py.File(small.build / "series_test.h5") as file:
        first, second, difference = (file[f"series/{o}"][()] for o in ("TM1_a_x", "TM2_a_x", "TM1_a_x-TM2_a_x"))
    np.testing.assert_allclose(difference, first - second, rtol=0, atol=1e-9 * np.abs(first).max())


GOOD = "time_s,outside,inside\n" + "".join(f"{4 * n},293.{n % 7},293\n" for n in range(9000))


@pytest.mark.parametrize(
    ("old", "new", "place", "fact"),
    [
        ("48,293.5,293\n", "48,293.5,\n", "t.csv:14", "inside must be a number, found nothing"),
        ("48,293.5,293\n", "48,293.5,warm\n", "t.csv:14", "inside must be a number, found 'warm'"),
        ("48,293.5,293\n", "48,nan,293\n", "t.csv:14", "outside is nan"),
        ("48,293.5,293\n", "48,293.5\n", "t.csv:14", "2 fields, wanted 3"),
        ("48,293.5,293\n", "\n48,293.5,293,\n", "t.csv:15", "4 fields, wanted 3"),
        ("48,293.5,293\n", "", "t.csv:14", "a gap of 8 s, some 1 samples of 4 s"),
        ("48,293.5,293\n", "44,293.5,293\n", "t.csv:14", "time_s is 44 after 44"),
        ("48,293.5,293\n", "47,293.5,293\n", "t.csv:14", "a step of 3 s among steps of 4 s"),
        ("outside,inside", "outside,insid", "t.csv", "column 'insid' names no thermal area"),
        ("outside,inside", "outside,outside", "t.csv", "column 'outside' is there twice (columns 2 and 3)"),
        ("time_s,outside,inside", "all,time_s,all", "t.csv:1", "column 'all' is there twice (columns 1 and 3)"),
        ("time_s,outside,inside", "time_s,time_s,all", "t.csv:1", "column 'time_s' is there twice (columns 1 and 2)"),
        ("outside,inside", "outside,STRUT_1", "t.csv", "thermal areas: "),
        ("time_s", "time", "t.csv:1", "there is no column time_s; there are: time, outside, inside"),
    ],
)  # fmt: skip
def test_what_is_wrong_with_a_table_is_said_by_line(
    chain: Project, small: Project, old: str, new: str, place: str, fact: str
) -> None:
    assert old in GOOD
    (small.folder / "t.csv").write_text(GOOD.replace(old, new, 1))
    configure(small)
    before = snapshot(small.build)
    small.run("run-series", "test").refused(4, place, fact)
    assert snapshot(small.build) == before


@pytest.mark.parametrize(
    ("more", "remove", "code", "fact"),
    [
        ("resample_s = 1.0\n", "mean", 3, "resample_s and method"),
        ("max_gap_s = 1.0\n", "mean", 3, "max_gap_s is for irregular stamps"),
        ("", "trend", 3, "series[0].remove"),
        ('spectrum = "log"\nlowest_hz = 1e-3\n', "mean", 3, "lowest_hz is for welch"),
        ('resample_s = 9.0\nmethod = "linear"\n', "mean", 4, "coarser than the steps of 4 s"),
        ("lowest_hz = 1e-5\n", "mean", 4, "9,000 samples of 4 s (36000 s) are too few for a spectrum from 1e-05 Hz"),
        ('constant = ["X_*"]\n', "mean", 3, "no thermal area has 'X_*'"),
    ],
)
def test_settings_that_contradict_the_series(small: Project, more: str, remove: str, code: int, fact: str) -> None:
    (small.folder / "t.csv").write_text(GOOD)
    configure(small, remove=remove, more=more)
    small.run("run-series", "test").refused(code, fact)


def test_areas_may_be_said_to_be_constant(small: Project) -> None:
    (small.folder / "t.csv").write_text(GOOD.replace("outside,inside", "outside,IS1").replace("time_s,", "time_s,", 1))
    configure(small, more='constant = ["*"]\n')
    small.run("run-series", "test").ok()
    found, file = result(small)
    file.close()
    assert not found.any()


def test_irregular_stamps_are_resampled_on_request(small: Project) -> None:
    """A straight line through irregular stamps stays one, whatever the method does to stamps."""
    rng = np.random.default_rng(4)
    time = np.cumsum(rng.uniform(2.0, 6.0, 9000))
    write_hdf5(small.folder / "t.h5", {"time_s": time, "all": 1e-6 * time})
    configure(small, "t.h5")
    small.run("run-series", "test").refused(4, "t.h5: row ", "a step of", hint="resample_s")
    replace(
        small.folder / "cases.toml", 'remove = "mean"\n', 'remove = "linear"\nresample_s = 2.5\nmethod = "linear"\n'
    )
    small.run("run-series", "test").ok()
    found, file = result(small)
    file.close()
    rows, _, _ = matrices(small)
    assert np.all(np.abs(found).max(axis=1) <= 1e-9 * np.abs(rows).sum(axis=1) * 1e-6 * time[-1])


def test_names_and_missing_files(small: Project) -> None:
    small.run("run-series", "test").refused(2, "there is no series 'test'; there are: none", hint="[[series]]")
    configure(small, "gone.csv")
    small.run("run-series", "tset").refused(2, "there are: test", hint="did you mean test?")
    small.run("run-series", "test").refused(4, "gone.csv")
    (small.folder / "gone.csv").write_text("time_s,all\n")
    small.run("run-series", "test").refused(4, "gone.csv", "0 rows")
    replace(small.folder / "cases.toml", "gone.csv", "gone.h5")
    (small.folder / "gone.h5").write_text("no")
    small.run("run-series", "test").refused(4, "gone.h5", "not a readable HDF5 file")
    write_hdf5(small.folder / "gone.h5", {"time_s": np.arange(3.0), "all": np.arange(4.0)})
    small.run("run-series", "test").refused(4, "/all has 4 values, /time_s 3")
    write_hdf5(small.folder / "gone.h5", {"time_s": np.arange(3.0), "all": np.ones((3, 2))})
    small.run("run-series", "test").refused(4, "no columns, as they are not one-dimensional and of real numbers: all")
    replace(small.folder / "cases.toml", 'remove = "mean"', "")
    replace(small.folder / "cases.toml", 'name = "test"', 'name = "a/b"')
    small.run("run-series", "test").refused(
        3, "series[0].remove: missing; wanted one of 'nothing', 'mean', 'linear'", "made of letters"
    )


DIFFERENCE = """
[[requirement]]
name = "lpf_acceleration"
outputs = ["TM1_a_x-TM2_a_x"]
applies_to = "differential"
"""


def test_requirements_on_differences_are_judged(small: Project, temperature: np.ndarray) -> None:
    """As they are in cases: the difference is an output like any other."""
    write_csv(small.folder / "t.csv", table(temperature))
    configure(small)
    cases = small.folder / "cases.toml"
    cases.write_text(cases.read_text() + DIFFERENCE)
    out = small.run("run-series", "test").ok().out
    assert "TM1_a_x-TM2_a_x  lpf_acceleration" in out
    with h5py.File(small.build / "series_test.h5") as file:
        y = {label: file[f"series/{label}"][()] for label in ("TM1_a_x", "TM2_a_x", "TM1_a_x-TM2_a_x")}
        assert b"TM1_a_x-TM2_a_x" in file["/verdict/output"][()]
    first, second, difference = y.values()
    np.testing.assert_allclose(difference, first - second, rtol=0, atol=1e-12 * np.abs(first).max())
    replace(cases, '"TM1_a_x-TM2_a_x"]\n', '"TM1_a_x-TM3_a_x"]\n')
    for command, what in (("run-series", "test"), ("run-case", "3")):
        small.run(command, what).refused(
            3, "cases.toml: requirement[2].outputs: there is no output 'TM1_a_x-TM3_a_x'; did you mean"
        )
    replace(cases, '"TM1_a_x-TM3_a_x"]\napplies_to = "differential"\n', '"TM1_a_x-TM2_a_x", "A_TM1_x"]\n')
    for command, what in (("run-series", "test"), ("run-case", "3")):
        small.run(command, what).refused(
            3, "lpf_acceleration is for single outputs", "A_TM1_x: lpf_acceleration limits acceleration"
        )


def test_a_series_that_is_refused_keeps_no_other_from_running(small: Project, temperature: np.ndarray) -> None:
    write_csv(small.folder / "t.csv", table(temperature))
    bad = table(temperature)
    bad["inside"] = np.where(np.arange(ROWS) == 700, np.nan, bad["inside"])
    write_csv(small.folder / "bad.csv", bad)
    text = "".join(
        SERIES.replace('"test"', f'"{name}"').format(file=file, remove="mean", more="")
        for name, file in (("first", "bad.csv"), ("good", "t.csv"), ("last", "gone.csv"))
    )
    cases = small.folder / "cases.toml"
    cases.write_text(cases.read_text() + text)
    outcome = small.run("run-series", "all")
    outcome.refused(4, "bad.csv:702: inside is nan", hint="refused too: series last")
    assert "series good: " in outcome.out
    assert [p.name for p in small.build.glob("series_*")] == ["series_good.h5"]


def test_all_of_no_series_is_no_fault(small: Project) -> None:
    """Series are optional, so `all` of none has nothing to do, and says how to add one; a name must be there."""
    for command in (("run-series", "all"), ("simulate", "--series", "all")):
        said = small.run(*command).ok().out
        assert said.count("\n") == 1
        assert "cases.toml describes no time series, so nothing was run; add one as a table [[series]]" in said
        found = small.run(*command, "--json").ok()
        assert (json.loads(found.out), found.err) == ([], said)
    small.run("run-series", "cooldown").refused(2, "there is no series 'cooldown'")


def test_log_spectra_need_speckit(small: Project, monkeypatch: pytest.MonkeyPatch) -> None:
    (small.folder / "t.csv").write_text(GOOD)
    configure(small, more='spectrum = "log"\n')
    monkeypatch.setitem(sys.modules, "speckit", None)
    small.run("run-series", "test").refused(2, "needs speckit", hint="pip install 'tedm[spectra]'")


def test_log_spectra_of_white_noise(small: Project) -> None:
    series = 1e-4 * np.random.default_rng(5).normal(size=20_000)
    write_hdf5(small.folder / "t.h5", {"time_s": STEP * np.arange(20_000), "all": series})
    configure(small, "t.h5", more='spectrum = "log"\n')
    small.run("run-series", "test").ok()
    found, file = result(small)
    with file:
        psd, f, nu = (file[n][()] for n in ("psd/A_TM2_x", "frequency", "degrees_of_freedom"))
    ratio = psd / (found[list(range(24))[15]].var() * 2 * STEP)
    assert f[0] == pytest.approx(8 / (20_000 * STEP), rel=1e-9, abs=0)
    assert np.diff(np.log(f)).max() < 0.15
    assert np.average(ratio, weights=nu) == pytest.approx(1.0, abs=0.02)


def test_reading_holds_a_block_and_not_the_table(tmp_path: Path) -> None:
    write_csv(tmp_path / "t.csv", {"time_s": np.arange(30_000.0), **{f"A{i}": np.ones(30_000) for i in range(8)}})
    peak = []
    for rows in (100, 1000):
        tracemalloc.start()
        with open_wide(tmp_path / "t.csv", "time_s", TIME_STAMP, TEMPERATURE) as wide:
            assert sum(len(b.key) for b in wide.blocks(rows)) == 30_000
        peak.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peak[1] < 1e6 < 30_000 * 9 * 8
    assert peak[0] < peak[1]


def test_cases_with_spectra_from_a_table(small: Project) -> None:
    """The thesis' spectrum through a fine table gives its verdicts; the table is an input that check watches."""
    before = json.loads(small.run("run-case", "3", "--json").ok().out)[0]["verdicts"]
    f = np.geomspace(1e-4, 0.1, 2001)
    shape = np.sqrt(2 / (1 + (f / 1e-3) ** 4))
    columns = {"frequency_hz": f, "outside": 1e-3 * shape, "inside": 1e-4 * shape}
    text = (small.folder / "cases.toml").read_text()
    head, _, rest = text.partition("[temperature]")
    rest = rest[rest.index("[frequency]") :]
    for name, write in (("s.csv", write_csv), ("s.h5", write_hdf5)):
        write(small.folder / name, columns)
        (small.folder / "cases.toml").write_text(f'{head}[temperature]\npreset = "table"\ntable = "{name}"\n{rest}')
        after = json.loads(small.run("run-case", "3", "--json").ok().out)[0]
        for a, b in zip(after["verdicts"], before, strict=True):
            assert a["ratio"] == pytest.approx(b["ratio"], rel=1e-5, abs=0)
        assert f"table outside of {small.folder / name}" in after["setting"]
    write_hdf5(small.folder / "s.h5", columns | {"outside": 2e-3 * shape})
    assert "s.h5 has changed" in tedm("check", "-d", small.build).out
    write_hdf5(small.folder / "s.h5", {name: v[100:] for name, v in columns.items()})
    small.run("run-case", "3").refused(4, "0.0001 Hz is asked for", hint="narrow [frequency]")


def test_a_case_with_a_realisation(small: Project) -> None:
    with open(small.folder / "cases.toml", "a") as stream:
        stream.write("\n[realisation]\nseed = 3\ntolerance = 0.3\n")
    out = small.run("run-case", "3").ok().out
    assert "realisation: " in out
    assert "seed 3" in out
    with h5py.File(small.build / "case03.h5") as file:
        group = file["realisation"]
        ratio = group["psd"][()] / group["exact"][()]
        assert np.abs(ratio.mean(axis=1) - 1.0).max() < 0.03
        first = group["psd"][()]
    small.run("run-case", "3").ok()
    with h5py.File(small.build / "case03.h5") as file:
        np.testing.assert_array_equal(file["realisation/psd"][()], first)


@pytest.mark.parametrize(
    ("keys", "path"),
    [
        ("rate_hz = 0.15", "realisation.rate_hz"),
        ("lowest_hz = 1e-5", "realisation.lowest_hz"),
        ("samples = 7999", "realisation.samples"),
        ("samples = 10000\ntolerance = 0.1", "not both"),
    ],
)
def test_realisations_that_cannot_be(small: Project, keys: str, path: str) -> None:
    with open(small.folder / "cases.toml", "a") as stream:
        stream.write(f"\n[realisation]\nseed = 3\n{keys}\n")
    small.run("run-case", "3").refused(3, path)


def test_a_realisation_with_delays(small: Project) -> None:
    cases = small.folder / "cases.toml"
    cases.write_text(
        cases.read_text()
        + '\n[[case]]\nid = "late"\ntitle = "One side follows"\nblocks = [{ areas = ["*"] }]\n'
        + 'delays = [{ side = ["-y"], delay_s = 333.3 }]\n\n[realisation]\nseed = 3\ntolerance = 0.3\n'
    )
    small.run("run-case", "late").ok()
    with h5py.File(small.build / "caselate.h5") as file:
        group = file["realisation"]
        ratio = group["psd"][()] / group["exact"][()]
        assert np.abs(ratio.mean(axis=1) - 1.0).max() < 0.03
    cases.write_text(cases.read_text().replace("333.3", "1e9"))
    small.run("run-case", "late").refused(4, "case late: realisation", "1e+09 s later", hint="shorten the delays")


def log_realisation(small: Project) -> None:
    with open(small.folder / "cases.toml", "a") as stream:
        stream.write('\n[realisation]\nseed = 3\nsamples = 20_000\nlowest_hz = 1e-3\nspectrum = "log"\n')


def test_log_spectra_of_a_realisation_need_speckit(small: Project, monkeypatch: pytest.MonkeyPatch) -> None:
    log_realisation(small)
    monkeypatch.setitem(sys.modules, "speckit", None)
    small.run("run-case", "3").refused(2, "needs speckit", hint="pip install 'tedm[spectra]'")


def test_log_spectra_of_a_realisation(small: Project) -> None:
    """Against the exact spectra through a window of another width at every frequency."""
    log_realisation(small)
    assert "log-spaced spectra" in small.run("run-case", "3").ok().out
    with h5py.File(small.build / "case03.h5") as file:
        group = file["realisation"]
        assert group["method"].asstr()[()] == "log"
        f, nu, exact = (group[name][()] for name in ("frequency", "degrees_of_freedom", "exact"))
        ratio = group["psd"][()] / exact
    assert 1e-3 <= f[0] < 1.05e-3
    assert 0.09 < f[-1] <= 0.1
    assert np.diff(np.log(f)).max() < 0.08
    assert np.abs(np.average(ratio, axis=1, weights=nu) - 1.0).max() < 0.02
    low, high = Estimate(f, ratio, nu).interval(0.95)
    assert np.mean((ratio * low <= 1.0) & (ratio * high >= 1.0)) > 0.88
