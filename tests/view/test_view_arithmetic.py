"""The numbers of the page are tedm's: its own arithmetic, run without a browser, against NumPy and exact sums."""

from __future__ import annotations

import base64
import math
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from view_project import Built

from tedm_cli.config.cases import load_cases
from tedm_cli.contracts import CASE, DISTORTION, UNIT_LOADS
from tedm_cli.files.build_folder import case_file_name
from tedm_cli.files.store import open_checked
from tedm_cli.results.cases.file import read_bound, read_case, read_psd
from tedm_cli.results.outputs import read_outputs
from tedm_cli.view.packing import numbers, places, quantised, steps

pytest.importorskip("py_mini_racer", reason="mini-racer, of the dev extra, is not installed")
from page_program import Program, inflated


@pytest.fixture(scope="module")
def program() -> Program:
    return Program("arithmetic.js", "format.js", "colours.js")


@pytest.mark.parametrize("length", range(9))
def test_base64(program: Program, length: int) -> None:
    raw = bytes((37 * i + 200) % 256 for i in range(length))
    assert bytes(program.run("Arithmetic.bytes(t)", t=base64.b64encode(raw).decode())) == raw


def test_numbers_keep_every_bit(program: Program) -> None:
    rng = np.random.default_rng(1)
    values = np.array(
        [0.0, -0.0, np.nan, np.inf, 5e-324, 1.7e308, *rng.normal(size=50) * 10.0 ** rng.integers(-300, 300, 50)]
    )
    found = np.array(program.run("Arithmetic.numbers(p)", p=numbers(values)))
    np.testing.assert_array_equal(found, values)
    np.testing.assert_array_equal(np.signbit(found[:2]), [False, True])


def test_sixteen_bits_and_places_come_back(program: Program) -> None:
    rng = np.random.default_rng(2)
    given = rng.integers(-32767, 32768, (3, 41)).astype(np.int16)
    given[0, :4] = [-32767, 32767, -32767, 0]  # steps that do not fit into 16 bits
    packed = steps(given)
    found = program.run("Arithmetic.steps(s, Arithmetic.bytes(t))", s=packed["shape"], t=inflated(packed, "int16"))
    np.testing.assert_array_equal(found, given.reshape(-1))
    rows = rng.integers(-1, 2**30, (7, 4))
    packed = places(rows)
    expression = "Arithmetic.words(s, Arithmetic.bytes(t), Int32Array)"
    np.testing.assert_array_equal(
        program.run(expression, s=packed["shape"], t=inflated(packed, "int32")), rows.reshape(-1)
    )


def test_outputs_are_exact_where_terms_cancel(program: Program) -> None:
    """Rows whose terms cancel to a part in 10^14, against rational arithmetic: NumPy itself would lose all digits."""
    rng = np.random.default_rng(3)
    rows, x = rng.normal(size=(6, 41)) * 1e-9, rng.normal(size=41) * 1e-3
    rows[:, -1] = -(rows[:, :-1] @ x[:-1]) / x[-1] * (1 + 1e-14)
    exact = [float(sum(Fraction(a) * Fraction(b) for a, b in zip(row, x, strict=True))) for row in rows.tolist()]
    found = program.run("Arithmetic.outputs(r, x)", r=rows, x=x)
    np.testing.assert_allclose(found, exact, rtol=1e-12, atol=0.0)
    assert np.abs(rows @ x / exact - 1.0).max() > 1e-12


def patterns(program: Program, content: dict[str, Any], k: int) -> dict[str, np.ndarray]:
    """Every pattern that can be chosen in the page, and samples of every film."""
    found = {"uniform": np.full(k, 1e-3), **{f"area {a}": 1e-3 * np.eye(k)[a] for a in range(k)}}
    rng = np.random.default_rng(4)
    found |= {f"hand {n}": rng.normal(size=k) * 10.0 ** rng.integers(-6, 1, k) for n in range(20)}
    for case in content["cases"]:
        for v in case["verdicts"]:
            for kind in ("typical", "worst"):
                key = f"case {case['id']} {kind} {v['output']}"
                found[key] = np.array(program.run("Arithmetic.numbers(p)", p=v[kind]))
    for film in (content["series"][0], *(case["film"] for case in content["cases"])):
        for sample in (0, 17, len(base64.b64decode(film["time"]["float64"])) // 8 - 1):
            found[f"{film['words']} {sample}"] = frame(program, film, sample)
    return found


def frame(program: Program, film: dict[str, Any], sample: int) -> np.ndarray:
    expression = (
        "Arithmetic.frame({time: Arithmetic.numbers(f.time), scale: Arithmetic.numbers(f.scale),"
        " steps: Arithmetic.steps(f.steps.shape, Arithmetic.bytes(t))}, s)"
    )
    return np.array(program.run(expression, f=film, t=inflated(film["steps"], "int16"), s=sample))


def test_outputs_of_every_pattern_are_those_of_tedm(program: Program, built: Built) -> None:
    _, config = load_cases(built.project.cases)
    outputs = read_outputs(built.project).with_differences(config.applied_requirements())
    assert built.content["outputs"]["label"] == list(outputs.labels)
    chosen = patterns(program, built.content, len(outputs.areas))
    assert len(chosen) > 60
    for name, t in chosen.items():
        found = program.run("Arithmetic.outputs(Arithmetic.numbers(r), t)", r=built.content["outputs"]["rows"], t=t)
        exact = [math.fsum(row * t) for row in outputs.rows]
        room = 1e-12 * np.abs(exact) + 1e-15 * (np.abs(outputs.rows) @ np.abs(t))  # products are rounded before the sum
        assert (np.abs(np.array(found) - exact) <= room).all(), name
        np.testing.assert_allclose(
            found, outputs.rows @ t, rtol=0, atol=1e-12 * (np.abs(outputs.rows) @ np.abs(t)).max()
        )


def test_patterns_of_a_case_make_what_its_file_says(program: Program, built: Built) -> None:
    """One standard amplitude of the output, and the largest that any correlation makes of it."""
    rows = np.array(program.run("Arithmetic.numbers(r)", r=built.content["outputs"]["rows"])).reshape(
        built.content["outputs"]["rows"]["shape"]
    )
    labels = built.content["outputs"]["label"]
    for case in built.content["cases"]:
        with open_checked(built.project.build_dir / case_file_name(case["id"]), CASE) as file:
            frequency = file.array(CASE.FREQUENCY)
            for v in case["verdicts"]:
                label = labels[v["output"]]
                f = int(np.flatnonzero(frequency == v["patternHz"])[0])
                assert (
                    v["patternHz"]
                    == file.array(CASE.CONTRIBUTION_FREQUENCY)[file.strings(CASE.OUTPUT_LABEL).index(label)]
                )
                typical, worst = (np.array(program.run("Arithmetic.numbers(p)", p=v[k])) for k in ("typical", "worst"))
                of_case, bound = read_psd(file, [label])[0, f], read_bound(file, "maximum", [label])[0, f]
                np.testing.assert_allclose(rows[v["output"]] @ typical, np.sqrt(of_case), rtol=1e-9)
                np.testing.assert_allclose(rows[v["output"]] @ worst, np.sqrt(bound), rtol=1e-12)
                assert (len(case["silent"]) > 0) == (case["id"] == "7")
                assert (typical[case["silent"]] == 0.0).all()
                assert (worst[case["silent"]] == 0.0).all()


def test_spectra_and_ratios_are_those_of_the_case_files(program: Program, built: Built) -> None:
    limits = built.content["limits"]
    amplitude = np.array(program.run("Arithmetic.numbers(p)", p=limits["amplitude"])).reshape(
        limits["amplitude"]["shape"]
    )
    for case in built.content["cases"]:
        with open_checked(built.project.build_dir / case_file_name(case["id"]), CASE) as file:
            known = read_case(file)
        assert len(known.judged) == len(case["verdicts"]) > 0
        np.testing.assert_array_equal(program.run("Arithmetic.numbers(p)", p=limits["frequency"]), known.frequency_hz)
        for judged, v in zip(known.judged, case["verdicts"], strict=True):
            assert built.content["outputs"]["label"][v["output"]] == judged.output
            assert limits["name"][v["limit"]] == judged.requirement
            asd = np.array(program.run("Arithmetic.numbers(p)", p=v["asd"]))
            np.testing.assert_array_equal(asd, judged.asd)
            ratio = program.run(
                "a.map((v, i) => Arithmetic.ratio(s, v, l[i]))", a=asd, l=amplitude[v["limit"]], s=case["safety"]
            )
            assert np.nanmax(ratio) == pytest.approx(judged.ratio, rel=1e-12)
            assert known.frequency_hz[np.nanargmax(ratio)] == pytest.approx(judged.binding_hz, rel=1e-9)
            assert v["ratio"] == judged.ratio
            place = program.run("Arithmetic.nearest(f, hz)", f=known.frequency_hz, hz=judged.binding_hz)
            assert known.frequency_hz[place] == judged.binding_hz


def test_displacements_are_right_to_half_a_step(program: Program, built: Built) -> None:
    """Of every area its largest displacement is 32767 steps; sums of areas add up their halves of a step."""
    mesh = built.content["drawing"]["mesh"]
    with open_checked(built.project.build_dir / "distortion.h5", DISTORTION) as file:
        D = file.array(DISTORTION.D_TRANSLATION).astype(np.float64)
    k, n = D.shape[0], mesh["position"]["shape"][0]
    assert n == 504
    position = np.array(
        program.run(
            "Arithmetic.words(s, Arithmetic.bytes(t), Float32Array)",
            s=mesh["position"]["shape"],
            t=inflated(mesh["position"], "float32"),
        )
    ).reshape(n, 3)
    with open_checked(built.project.build_dir / "unit_loads.h5", UNIT_LOADS) as unit:
        places_of = {
            tuple(p): i for i, p in enumerate(unit.array(UNIT_LOADS.GRID_POSITION).astype(np.float32).tolist())
        }
    D = D[:, [places_of[tuple(p)] for p in position.astype(np.float32).tolist()]]
    rng = np.random.default_rng(6)
    step = np.array(program.run("Arithmetic.numbers(p)", p=mesh["scale"]))
    for temperature in (*np.eye(k)[:5], np.ones(k), rng.normal(size=k)):
        moved = program.run(
            "Arithmetic.displace({scale: Arithmetic.numbers(m.scale),"
            " steps: Arithmetic.steps(m.steps.shape, Arithmetic.bytes(t))}, x, new Float64Array(m.steps.shape[1]))",
            m=mesh, t=inflated(mesh["steps"], "int16"), x=temperature,
        )  # fmt: skip
        found = np.array(moved).reshape(3, n).T
        exact = np.einsum("k,knc->nc", temperature, D)
        assert np.abs(found - exact).max() <= 0.5 * (np.abs(temperature) @ step) * (1 + 1e-9)
        largest = program.run("Arithmetic.largest(m)", m=np.array(moved))
        assert largest["value"] == pytest.approx(np.linalg.norm(found, axis=1).max(), rel=1e-12)
        assert largest["at"] == np.linalg.norm(found, axis=1).argmax()
    np.testing.assert_allclose(step, np.abs(D).max(axis=(1, 2)) / 32767, rtol=1e-12)


def test_nothing_that_moves_is_no_displacement(program: Program) -> None:
    assert program.run("Arithmetic.largest(new Float64Array(9))") == {"value": 0, "at": -1}
    empty = quantised(np.zeros((2, 6)))
    assert (empty.scale == 0).all()
    assert (empty.values() == 0).all()


@pytest.mark.parametrize(("moved", "length"), [(23e-9, 1.2), (1e-12, 0.4), (7.3e-4, 3.0), (2.0, 0.1)])
def test_exaggeration_has_two_digits_and_hardly_less_than_is_wanted(
    program: Program, moved: float, length: float
) -> None:
    factor = program.run("Arithmetic.exaggeration(m, l, 0.05)", m=moved, l=length)
    assert 0.9 * 0.05 <= factor * moved / length <= 0.05 * (1 + 1e-9)
    assert float(f"{factor:.1e}") == factor
    assert program.run("Arithmetic.exaggeration(0, l, 0.05)", l=length) == 1


@pytest.mark.parametrize(
    ("expression", "text"),
    [
        ("si(2.345e-8, 'm')", "23.4 nm"), ("si(-9.996e-13, 'm')", "−1.00 pm"), ("si(999.6, 'K')", "1.00 kK"),
        ("si(0, 'm')", "0 m"), ("si(NaN, 'm')", "–"), ("si(1e-15, 'm/s²/√Hz')", "1.00 fm/s²/√Hz"),
        ("si(1e-40, 'm')", "1.00 × 10⁻⁴⁰ m"), ("ratio(1.0000001)", "1.0000001"), ("ratio(0.99996)", "0.99996"),
        ("ratio(1.776)", "1.78"), ("ratio(0)", "0"), ("ratio(123456)", "1.23 × 10⁵"),
        ("factor(210000)", "210\u202f000"),
        ("factor(4.7e9)", "4.7 × 10⁹"), ("factor(0.021)", "2.1 × 10⁻²"), ("unit('m s^-2')", "m/s²"),
        ("time(90)", "90 s"), ("time(86400)", "24.00 h"), ("count(1, 'grid')", "1 grid"), ("decade(1e-12)", "10⁻¹²"),
        ("count(12345, 'grid')", "12\u202f345 grids"),
    ],
)  # fmt: skip
def test_numbers_as_words(program: Program, expression: str, text: str) -> None:
    assert program.run(f"Format.{expression}") == text


def test_colours_are_centred_on_zero(program: Program) -> None:
    middle = program.run("Colours.diverging(0)")
    assert max(middle) - min(middle) < 6  # grey
    cold, warm = program.run("Colours.diverging(-0.7)"), program.run("Colours.diverging(0.7)")
    assert cold[2] > cold[0] + 50
    assert warm[0] > warm[2] + 50
    light = [sum(program.run("Colours.sequential(t)", t=t)) for t in np.linspace(0, 1, 9).tolist()]
    assert light == sorted(light, reverse=True)
