"""The worked example: matrices step by step, every total, margins and the free response, against 50 digits."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from dynamics_models import EXAMPLE, controlled, example, example_plant
from scipy import linalg

from tedm_cli.dynamics.closed_loop import responses
from tedm_cli.dynamics.controller import LOOPS, ScalarLoops, actuation, default_loops
from tedm_cli.dynamics.signals import COORDINATES, INPUTS
from tedm_cli.dynamics.stability import stability
from tedm_cli.dynamics.state_space import loop_system
from tedm_cli.stages.dynamics.problem import solve_problem


@pytest.mark.parametrize("name", ["E", "K", "M18", "K18", "U18", "actuation"])
def test_matrices(name: str) -> None:
    plant = example_plant()
    mass, stiffness, inputs = plant.eighteen()
    ours = {
        "E": plant.E, "K": plant.K, "M18": mass, "K18": stiffness, "U18": inputs, "actuation": actuation(plant)
    }[name]  # fmt: skip
    reference = np.array(example()["matrices"][name])
    scale = np.abs(reference).max(axis=1, keepdims=True) + np.finfo(float).tiny
    np.testing.assert_allclose(ours / scale, reference / scale, atol=2e-14)


def test_loops_by_coefficients_and_response() -> None:
    matrices = example()["matrices"]
    loops = {loop.name: loop for loop in default_loops()}
    assert tuple(matrices["loops"]) == LOOPS
    numerator, denominator = loops["TM1_x"].coefficients
    np.testing.assert_allclose(numerator, matrices["pid_TM1_x"]["numerator"], rtol=1e-14)
    np.testing.assert_allclose(denominator, matrices["pid_TM1_x"]["denominator"], rtol=1e-14)
    s = np.array([2j * np.pi * 0.01])
    for name, (real, imaginary) in matrices["loop_response_at_10_mHz"].items():
        wanted = complex(real, imaginary)
        assert abs(loops[name].response(s)[0] - wanted) < 1e-14 * abs(wanted)
        assert abs(loops[name].state_space().response(s)[0, 0, 0] - wanted) < 1e-13 * abs(wanted)


def test_every_total_and_contribution() -> None:
    ours, reference = solve_problem(EXAMPLE), example()["result"]
    assert ours["output"] == reference["output"]
    total, wanted = np.array(ours["psd_total"]), np.array(reference["psd_total"])
    assert total.shape == (8, 75)
    np.testing.assert_allclose(total, wanted, rtol=1e-9)
    for group, parts in reference["psd"].items():
        # a part of a thousandth of its total has three digits fewer
        ours_of, part = np.array(ours["psd"][group]), np.array(parts)
        felt = part > 1e-3 * wanted
        np.testing.assert_allclose(ours_of[felt], part[felt], rtol=1e-8)
        assert (np.abs(ours_of - part) <= 1e-6 * part + 1e-11 * wanted).all()


def test_stability_and_margins() -> None:
    reference = example()["result"]["stability"]
    found = stability(example_plant(), controlled(example_plant()))
    assert len(found.poles) == reference["states"]
    assert found.largest_real_part == pytest.approx(reference["largest_real_part"], rel=1e-6)
    for margins in found.margins:
        wanted = reference["margins"][margins.loop]
        # those of the reference are read off a grid of frequencies
        assert margins.phase_deg == pytest.approx(wanted["phase_margin_deg"], abs=0.01)
        assert margins.gain_db == pytest.approx(wanted["gain_margin_dB"], abs=0.02)
        assert margins.reduction_db == pytest.approx(wanted["gain_reduction_dB"], abs=0.02)
        assert margins.peak_sensitivity == pytest.approx(wanted["peak_S"], rel=1e-6)


def test_a_problem_names_its_rows_in_any_order(tmp_path) -> None:
    """Mutual stiffness with its rows and columns turned, and the margins that a problem is answered with."""
    data = {k: v for k, v in example().items() if k not in ("result", "matrices", "free_response", "figure_6_2")}
    table, mutual = data["stiffness"], np.array(data["stiffness"]["mutual"])
    rows, columns = np.roll(np.arange(12), 5), np.arange(12)[::-1]
    turned = {
        "rows": [table["rows"][i] for i in rows],
        "columns": [table["columns"][i] for i in columns],
        "mutual": mutual[np.ix_(rows, columns)].tolist(),
    }
    path = tmp_path / "problem.json"
    path.write_text(json.dumps(data | {"stiffness": table | turned}))
    ours = solve_problem(path)
    np.testing.assert_allclose(ours["psd_total"], example()["result"]["psd_total"], rtol=1e-9)
    reference = example()["result"]["stability"]
    assert ours["stability"]["states"] == reference["states"]
    assert set(ours["stability"]["margins"]) == set(reference["margins"])
    for loop, margins in ours["stability"]["margins"].items():
        for name, value in margins.items():
            assert value == pytest.approx(reference["margins"][loop][name], abs=0.02), (loop, name)


def test_a_controller_of_a_problem_with_its_delay(tmp_path) -> None:
    """Loops without delay as matrices, and one delay of all commands: the loops with that delay."""
    plant, path = example_plant(), tmp_path / "problem.json"
    data = {k: v for k, v in example().items() if k not in ("result", "matrices", "free_response", "figure_6_2")}
    s = ScalarLoops(plant, [replace(x, delay_s=0.0) for x in default_loops()]).state_space()
    matrices = {"A": s.a, "B": s.b, "C": -s.c, "D": -s.d}
    own = {"kind": "state_space", "inputs": COORDINATES, "outputs": INPUTS, "delay_s": 0.4}
    own |= {name: matrix.tolist() for name, matrix in matrices.items()}
    table = data["controller"]
    late = table | {"loops": {name: loop | {"delay_s": 0.4} for name, loop in table["loops"].items()}}
    found = []
    for controller in (own, late):
        path.write_text(json.dumps(data | {"controller": controller}))
        found.append(solve_problem(path)["psd_total"])
    np.testing.assert_allclose(found[0], found[1], rtol=1e-8)


def test_free_response() -> None:
    free, system = example()["free_response"], loop_system(example_plant(), controlled(example_plant())).system
    start = np.zeros(len(system.a))
    start[:15] = free["p0"]
    for time, wanted in zip(free["time_s"], free["response"], strict=True):
        ours = (linalg.expm(system.a * time) @ start)[:15]
        np.testing.assert_allclose(ours, wanted, atol=1e-9 * np.abs(wanted).max())


def test_a_problem_that_is_none_is_refused(tmp_path) -> None:
    from tedm_cli.errors import ConfigError, InputError, PhysicsError

    def problem(**changes) -> object:
        data = {k: v for k, v in example().items() if k not in ("result", "matrices", "free_response", "figure_6_2")}
        path = tmp_path / "problem.json"
        path.write_text(json.dumps(data | changes))
        return solve_problem(path)

    heavy = example()["spacecraft"] | {"inertia_kg_m2": [[500.0, 0, 0], [0, 100.0, 0], [0, 0, 100.0]]}
    with pytest.raises(PhysicsError, match="exceeds the sum"):
        problem(spacecraft=heavy)
    with pytest.raises(ConfigError, match="unknown key"):
        problem(spacecrafts=1)
    with pytest.raises(InputError, match=r"stiffness\.mutual is 1 x 1"):
        problem(stiffness=example()["stiffness"] | {"mutual": [[1.0]]})
    with pytest.raises(ConfigError, match="frequency 0 is outside"):
        problem(frequency_hz=[0.0, 1e-3])
    with pytest.raises(InputError, match="above 0"):
        list(responses(example_plant(), None, np.array([0.0])))
    (tmp_path / "broken.json").write_text("{")
    with pytest.raises(InputError, match="is not JSON"):
        solve_problem(tmp_path / "broken.json")
