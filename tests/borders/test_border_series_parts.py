"""Series that a requirement's band or the areas fit in part: what is judged, what is said, and by which exit code."""

from __future__ import annotations

import json
from pathlib import Path

import h5py
import numpy as np
import pytest
from border_tools import Project, replace, tedm

from tedm_cli.noise.spectral_estimate import kaiser

STEP, ROWS, BIN = 4.0, 4000, 1.0 / 8000.0  # half of the series is a segment
SERIES = '\n[[series]]\nname = "test"\nfile = "{file}"\nremove = "{remove}"\n{more}'


def configure(project: Project, file: str = "t.h5", remove: str = "mean", more: str = "") -> None:
    with open(project.folder / "cases.toml", "a") as stream:
        stream.write(SERIES.format(file=file, remove=remove, more=more))


def write(path: Path, **columns: np.ndarray) -> None:
    with h5py.File(path, "w") as file:
        for name, values in columns.items():
            file[name] = values


def row(project: Project, label: str) -> float:
    """Response of an output to all areas together."""
    with h5py.File(project.build / "optics.h5") as file:
        labels = [f"A_{name}" for name in file["label/read_out"].asstr()[()]]
        return float(np.abs(file["N/A"][labels.index(label)].sum()))


def verdicts(found: dict[str, object]) -> dict[str, dict[str, object]]:
    return {v["output"]: v for v in found["verdicts"] if v["requirement"] == "lpf_readout_item"}  # type: ignore


@pytest.mark.parametrize(("tone_bin", "passed"), [(80, False), (20, True)], ids=["10 mHz", "2.5 mHz"])
def test_a_tone_is_judged_where_band_and_estimate_overlap(small: Project, tone_bin: int, passed: bool) -> None:
    """The band is 1 to 30 mHz, and a series of 16,000 s has a spectrum from 4 mHz on, and its rms from everywhere."""
    amplitude = 1e-2
    time = STEP * np.arange(ROWS)
    write(small.folder / "t.h5", time_s=time, all=amplitude * np.sin(2 * np.pi * tone_bin * BIN * time))
    configure(small)
    found = json.loads(small.run("run-series", "test", "--json").ok().out)[0]
    of_tm2 = verdicts(found)["A_TM2_x"]
    assert of_tm2["judged_hz"] == pytest.approx([4e-3, 30e-3], rel=1e-9)
    assert of_tm2["band_hz"] == [1e-3, 30e-3]
    assert of_tm2["whole_band"] is False
    assert (
        "A_TM1_x, A_TM2_x, B_TM1_x, B_TM2_x: lpf_readout_item over 0.001 to 0.004 Hz, below the estimate"
        in found["not_judged"]
    )
    response = amplitude * row(small, "A_TM2_x")
    rms = {o["output"]: o["rms"] for o in found["outputs"]}["A_TM2_x"]
    assert rms == pytest.approx(response / np.sqrt(2.0), rel=1e-6)
    assert of_tm2["passed"] is passed
    assert found["passed"] is passed
    if not passed:
        window = kaiser(2000)
        asd = response * window.sum() * np.sqrt(STEP / (2.0 * np.sum(window**2)))
        assert of_tm2["noise"] == pytest.approx(asd, rel=1e-3)
        assert of_tm2["ratio"] == pytest.approx(2.0 * asd / 1e-12, rel=1e-3), "the limit is 1 pm/√Hz above 3 mHz"
        assert of_tm2["binding_hz"] == pytest.approx(tone_bin * BIN)
        assert of_tm2["band_rms"] == pytest.approx(rms, rel=1e-2)
    outcome = small.run("run-series", "test", "--fail-on-violation")
    if passed:
        assert "pass in part" in outcome.ok().out
    else:
        outcome.refused(5, "requirements are violated in series test")
        assert "FAIL in part" in outcome.out
    assert "B_TM1_x, B_TM2_x: lpf_readout_item over 0.001 to 0.004 Hz, below the estimate" in outcome.out
    with h5py.File(small.build / "series_test.h5") as file:
        assert file["verdict/lowest"][0] == pytest.approx(4e-3)
        assert not file["verdict/whole_band"][()].any()
        assert len(file["unjudged"]) == len(found["not_judged"])
    assert "series_test.h5 (series): up to date" in tedm("check", "-d", small.build).out


def test_a_series_too_short_for_any_spectrum_has_its_rms(small: Project) -> None:
    time = STEP * np.arange(100)
    write(small.folder / "t.h5", time_s=time, all=np.cos(2 * np.pi * time / 40.0))
    configure(small)
    outcome = small.run("run-series", "test", "--fail-on-violation").ok()
    assert "the series is too short for a spectrum" in outcome.out
    assert "B_TM1_x, B_TM2_x: lpf_readout_item, as there is no spectrum" in outcome.out
    assert "\nnothing judged: neither a pass nor a violation\n" in outcome.out
    assert json.loads(small.run("run-series", "test", "--json").ok().out)[0]["passed"] is None
    with h5py.File(small.build / "series_test.h5") as file:
        labels = list(file["output/label"].asstr())
        rms = file["output/rms"][labels.index("A_TM2_x")]
        assert rms == pytest.approx(row(small, "A_TM2_x") / np.sqrt(2.0), rel=1e-9)
        assert file["frequency"].shape == (0,)
        assert len(file["verdict/passed"]) == 0


def test_a_series_of_steps_too_long_for_the_bands_is_not_called_short(small: Project) -> None:
    """Steps of 1000 s have nothing above 0.5 mHz, and no band begins below 1 mHz: a spectrum, and no verdict."""
    time = 1000.0 * np.arange(2500)
    write(small.folder / "t.h5", time_s=time, all=np.cos(2 * np.pi * time / 20e3))
    configure(small)
    outcome = small.run("run-series", "test", "--fail-on-violation").ok()
    assert "too short" not in outcome.out
    assert "2,500 samples of 1000 s (Nyquist frequency 0.0005 Hz)" in outcome.out
    assert "Hz: the samples are too far apart for the band" in outcome.out
    assert "nothing judged" in outcome.out
    with h5py.File(small.build / "series_test.h5") as file:
        frequency, labels = file["frequency"][()], file["output/label"].asstr()[()]
        assert frequency[0] < 1.0 / 20e3 < frequency[-1] < 5e-4
        psd = file[f"psd/{labels[0]}"][()]
        assert frequency[psd.argmax()] == pytest.approx(1.0 / 20e3, rel=0.03)
    replace(small.folder / "cases.toml", 'remove = "mean"\n', 'remove = "mean"\nlowest_hz = 1e-3\n')
    fact = "samples of 1000 s have a spectrum up to 0.0005 Hz, below lowest_hz = 0.001"
    small.run("run-series", "test").refused(4, fact, hint="a lower lowest_hz")


def test_celsius_with_decimal_commas_and_nodes_with_weights(small: Project) -> None:
    """What a thermal model writes, and the same temperatures of areas in kelvin: one result."""
    rng = np.random.default_rng(3)
    number = np.arange(1000)
    node = 20.0 + 1e-3 * rng.normal(size=(1000, 3)).cumsum(axis=0)
    columns = "\n".join(";".join([f"{STEP * n:g}", *(f"{v:.12f}" for v in node[n])]).replace(".", ",") for n in number)
    (small.folder / "t.csv").write_text(f"time_s;N1;N2;N7\n{columns}\n")
    with h5py.File(small.build / "sensitivity.h5") as file:
        names = list(file["area/name"].asstr())
    weights = [f"N1;{names[0]};0,25\nN2;{names[0]};0,75\n", *(f"N2;{name};1\n" for name in names[1:])]
    (small.folder / "n.csv").write_text("node;area;weight\n" + "".join(weights))
    configure(small, "t.csv", more='unit = "degC"\nweights = "n.csv"\n')
    out = small.run("run-series", "test").ok().out
    assert "areas from nodes by n.csv, degrees Celsius, of which only differences count, mean removed" in out
    with h5py.File(small.build / "series_test.h5") as file:
        nodes = {label: file[f"series/{label}"][()] for label in file["output/label"].asstr()}
        assert file["temperature/column"].asstr()[0] == "0.25 N1 + 0.75 N2"
        assert file["temperature/column"].asstr()[1] == "N2"
    kelvin = {name: node[:, 1] + 273.15 for name in names} | {names[0]: node[:, :2] @ [0.25, 0.75] + 273.15}
    write(small.folder / "t.h5", time_s=STEP * number, **kelvin)
    replace(small.folder / "cases.toml", '"t.csv"', '"t.h5"')
    replace(small.folder / "cases.toml", 'unit = "degC"\nweights = "n.csv"\n', "")
    small.run("run-series", "test").ok()
    with h5py.File(small.build / "series_test.h5") as file:
        for label, values in nodes.items():
            np.testing.assert_allclose(file[f"series/{label}"][()], values, rtol=0, atol=1e-8 * np.abs(values).max())


@pytest.mark.parametrize(
    ("remove", "more", "weights", "code", "fact"),
    [
        ("nothing", 'unit = "degC"\n', "", 3, 'unit = "degC" needs remove = "mean", "linear" or "reference"'),
        ("mean", 'unit = "degF"\n', "", 3, "series[0].unit: must be 'K' or 'degC'"),
        ("mean", 'weights = "n.csv"\n', None, 4, "n.csv: no such file"),
        ("mean", 'weights = "n.csv"\n', "N8,OB_TOP,1\nN9,STRUT_1,1\n", 4,
         "n.csv: no thermal area: OB_TOP; no column of "),
        ("mean", 'weights = "n.csv"\n', "all,STRUT_1,0.9\n", 4, "do not add up to 1: STRUT_1 (0.9)"),
        ("mean", 'weights = "n.csv"\nconstant = ["STRUT_*"]\n', "all,STRUT_1,1\n", 4, "said to be constant: STRUT_1"),
        ("mean", 'weights = "n.csv"\n', "all,STRUT_1,1\n", 4, "no column for "),
    ],
)  # fmt: skip
def test_units_and_weights_that_are_refused(
    small: Project, remove: str, more: str, weights: str | None, code: int, fact: str
) -> None:
    write(small.folder / "t.h5", time_s=STEP * np.arange(300), all=np.ones(300))
    if weights:
        (small.folder / "n.csv").write_text("node,area,weight\n" + weights)
    configure(small, remove=remove, more=more)
    small.run("run-series", "test").refused(code, fact)
    assert not (small.build / "series_test.h5").exists()


def test_check_watches_the_weights(small: Project) -> None:
    write(small.folder / "t.h5", time_s=STEP * np.arange(300), N1=np.arange(300.0), all=np.ones(300))
    (small.folder / "n.csv").write_text("node,area,weight\nN1,STRUT_1,1\n")
    configure(small, more='weights = "n.csv"\n')
    small.run("run-series", "test").ok()
    (small.folder / "n.csv").write_text("node,area,weight\nN1,STRUT_2,1\n")
    assert "n.csv has changed" in tedm("check", "-d", small.build).out
