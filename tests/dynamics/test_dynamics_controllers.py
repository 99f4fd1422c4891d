"""Controllers of one's own: the default one brought as matrices, delays, sampling, and what is refused by name."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import control
import numpy as np
import pytest
import scipy.io
from dynamics_models import askew_plant, controlled, example_plant
from scipy import linalg, signal

from tedm_cli.config.dynamics.controller_file import read_controller
from tedm_cli.dynamics import stability as stability_room
from tedm_cli.dynamics.bodies import DynamicTestMass, Spacecraft, check_inertia
from tedm_cli.dynamics.closed_loop import responses
from tedm_cli.dynamics.controller import DRAG_FREE, SUSPENSION, Controller, ScalarLoops, actuation, default_loops
from tedm_cli.dynamics.loops import Loop, StateSpace, pade_response
from tedm_cli.dynamics.own_controller import StateSpaceController
from tedm_cli.dynamics.plant import Plant
from tedm_cli.dynamics.sampled_loop import one_period
from tedm_cli.dynamics.signals import COORDINATES, INPUTS
from tedm_cli.dynamics.stability import stability
from tedm_cli.dynamics.state_space import loop_system
from tedm_cli.errors import InputError, PhysicsError

F = np.geomspace(1e-4, 0.3, 9)


def transfer(plant: Plant, controller: Controller | None, f: np.ndarray = F) -> np.ndarray:
    return np.concatenate([h for _, h in responses(plant, controller, f)])


def as_matrices(plant: Plant) -> StateSpace:
    """The default controller as u = C x + D y."""
    s = controlled(plant).state_space()
    return StateSpace(s.a, s.b, -s.c, -s.d)


def undelayed(plant: Plant) -> ScalarLoops:
    return ScalarLoops(plant, [Loop(x.name, x.crossover_hz, 0.0) for x in default_loops()])


@pytest.mark.parametrize("form", ["npz", "mat", "toml"])
def test_the_default_controller_from_a_file_is_the_default_controller(form: str, tmp_path: Path) -> None:
    plant = example_plant()
    s = as_matrices(plant)
    path = tmp_path / f"controller.{form}"
    names = {"inputs": list(COORDINATES[::-1]), "outputs": list(INPUTS[::-1])}
    matrices = {"A": s.a, "B": s.b[:, ::-1], "C": s.c[::-1], "D": s.d[::-1, ::-1]}
    if form == "npz":
        np.savez(path, **matrices, **{k: np.array(v) for k, v in names.items()})
    elif form == "mat":
        scipy.io.savemat(path, matrices | {k: np.array(v, dtype=object) for k, v in names.items()})
    else:
        lines = [f"{k} = {v!r}".replace("'", '"') for k, v in names.items()]
        lines += [f"{k} = {m.tolist()!r}" for k, m in matrices.items()]
        path.write_text("\n".join(lines))
    ours, own = transfer(plant, controlled(plant)), transfer(plant, read_controller(path))
    size = np.abs(ours).max(axis=(0, 2), keepdims=True) + np.finfo(float).tiny
    np.testing.assert_allclose(own / size, ours / size, atol=1e-9)
    assert stability(plant, read_controller(path)).largest_real_part == pytest.approx(-8.2e-5, rel=0.01)


def test_a_delay_of_all_commands() -> None:
    """Loops without delay and one delay behind them all are loops with that delay."""
    plant = example_plant()
    s = undelayed(plant).state_space()
    own = StateSpaceController(StateSpace(s.a, s.b, -s.c, -s.d), COORDINATES, INPUTS, delay_s=0.4)
    late = ScalarLoops(plant, [Loop(x.name, x.crossover_hz, 0.4) for x in default_loops()])
    ours, wanted = transfer(plant, own), transfer(plant, late)
    size = np.abs(wanted).max(axis=(0, 2), keepdims=True) + np.finfo(float).tiny
    np.testing.assert_allclose(ours / size, wanted / size, atol=1e-10)
    assert stability(plant, own).largest_real_part == pytest.approx(stability(plant, late).largest_real_part, rel=1e-5)


@pytest.mark.parametrize(("frequency", "off"), [(0.1, 6e-10), (0.5, 1.5e-4)])
def test_delays_are_pade_approximants(frequency: float, off: float) -> None:
    s = np.array([2j * np.pi * frequency])
    assert abs(pade_response(s, 0.4)[0] - np.exp(-0.4 * s[0])) < 1.2 * off
    assert abs(abs(pade_response(s, 0.4)[0]) - 1.0) < 1e-14


def test_a_sampled_controller_comes_to_the_continuous_one() -> None:
    """Discretised with held commands at ever shorter periods; the hold delays by half of them."""
    plant = example_plant()
    s = undelayed(plant).state_space()
    continuous = StateSpaceController(StateSpace(s.a, s.b, -s.c, -s.d), COORDINATES, INPUTS)
    wanted = transfer(plant, continuous)
    size = np.abs(wanted).max(axis=(0, 2), keepdims=True) + np.finfo(float).tiny
    errors = []
    for dt in (0.1, 0.05, 0.025):
        a, b, c, d, _ = signal.cont2discrete((s.a, s.b, -s.c, -s.d), dt, "bilinear")
        sampled = StateSpaceController(StateSpace(a, b, c, d), COORDINATES, INPUTS, dt_s=dt)
        errors.append((np.abs(transfer(plant, sampled) - wanted) / size).max())
        poles = stability(plant, sampled)
        assert poles.largest_real_part == pytest.approx(stability(plant, continuous).largest_real_part, rel=0.02)
    assert errors[0] > 1.7 * errors[1] > 2.9 * errors[2]


def test_hold_and_frequency_above_half_the_rate() -> None:
    """A gain sampled every dt and held: sinc with half a period's delay."""
    one = StateSpaceController(StateSpace.gain(np.ones((1, 1))), ("TM1_x",), ("SC_Fx",), dt_s=2.0)
    f = np.array([0.05, 0.2])
    got = -one.command(2j * np.pi * f)[:, INPUTS.index("SC_Fx"), 0]
    np.testing.assert_allclose(got, np.sinc(2.0 * f) * np.exp(-2j * np.pi * f), rtol=1e-13)
    with pytest.raises(PhysicsError, match=r"has no frequencies above 0\.25 Hz"):
        one.command(np.array([2j * np.pi * 0.3]))


def test_an_unstable_loop_is_refused_with_its_pole_and_coordinate() -> None:
    plant = example_plant()
    loops = [Loop(x.name, x.crossover_hz, 8.0 if x.name == "TM1_x" else x.delay_s) for x in default_loops()]
    with pytest.raises(PhysicsError, match=r"unstable: a pole at .* rad/s moves TM\d_x most"):
        stability(plant, ScalarLoops(plant, loops))
    nothing = StateSpaceController(StateSpace.gain(np.zeros((1, 1))), ("TM1_x",), ("SC_Fx",))
    with pytest.raises(PhysicsError, match="unstable"):
        stability(plant, nothing)


def test_a_direct_gain_in_the_system_and_at_single_frequencies() -> None:
    """The default loops have none; a controller of one's own may answer to the read-outs at once."""
    plant = askew_plant(2)
    gain = 1e-3 * np.random.default_rng(4).normal(size=(len(INPUTS), len(COORDINATES)))
    own = StateSpaceController(StateSpace.gain(gain), COORDINATES, INPUTS)
    wanted, ours = transfer(plant, own), loop_system(plant, own).response(2j * np.pi * F)
    size = np.abs(wanted).max(axis=(0, 2), keepdims=True)
    np.testing.assert_allclose(ours / size, wanted / size, atol=1e-11)


def test_axes_that_are_left_handed_are_refused() -> None:
    with pytest.raises(PhysicsError, match="axes of TM1 are not a right-handed"):
        DynamicTestMass("TM1", 2.0, np.full(3, 7e-4), np.zeros(3), np.diag([1.0, 1.0, -1.0]))


def test_an_improper_loop_is_refused() -> None:
    with pytest.raises(PhysicsError, match="loop TM1_x is improper: numerator of order 2, denominator of order 1"):
        Loop("TM1_x", 0.1, 0.4, transfer=((1.0, 2.0, 1.0), (1.0, 1.0)))
    proper = Loop("TM1_x", 0.1, 0.0, transfer=((2.0, 1.0), (1.0, 3.0)))
    s = np.array([0.3j])
    assert proper.response(s)[0] == pytest.approx((2.0 * s[0] + 1.0) / (s[0] + 3.0))
    assert proper.state_space().response(s)[0, 0, 0] == pytest.approx(proper.response(s)[0])


@pytest.mark.parametrize(
    ("inputs", "outputs", "fact"),
    [
        (("TM1_x", "TM1_x"), ("SC_Fx",), "input 'TM1_x' of the controller is named twice"),
        (("TM3_x", "TM1_x"), ("SC_Fx",), "unknown input 'TM3_x'"),
        (("TM1_x", "TM1_y"), ("SC_Fw",), "unknown output 'SC_Fw'"),
        (("TM1_x",), ("SC_Fx",), "D of the controller is 1 x 2; 0 states, 1 inputs and 1 outputs want 1"),
    ],
)
def test_names_and_shapes_are_refused(inputs: tuple[str, ...], outputs: tuple[str, ...], fact: str) -> None:
    with pytest.raises(PhysicsError, match=fact):
        gain = StateSpace(np.zeros((0, 0)), np.zeros((0, len(inputs))), np.zeros((1, 0)), np.ones((1, 2)))
        StateSpaceController(gain, inputs, outputs)


def test_files_that_are_no_controllers_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"its ending is '\.txt'"):
        read_controller(tmp_path / "c.txt")
    np.savez(tmp_path / "c.npz", D=np.eye(1))
    with pytest.raises(InputError, match="holds no inputs and no outputs"):
        read_controller(tmp_path / "c.npz")


@pytest.mark.parametrize(
    ("inertia", "fact"),
    [
        ([[200.0, 1.0, 0.0], [0.0, 200.0, 0.0], [0.0, 0.0, 200.0]], "is not symmetric"),
        (np.diag([200.0, -1.0, 200.0]), "principal moment of -1"),
        (np.diag([100.0, 100.0, 201.0]), "exceeds the sum"),
    ],
)
def test_an_inertia_that_no_body_has_is_refused(inertia: object, fact: str) -> None:
    with pytest.raises(PhysicsError, match=fact):
        Spacecraft(400.0, np.array(inertia), np.zeros(3))
    check_inertia(np.diag([100.0, 100.0, 200.0]))  # a thin plate


@pytest.mark.parametrize("apart", [0.0, 1e-11])
def test_test_masses_at_one_x_are_refused(apart: float) -> None:
    plant = example_plant()
    first, second = plant.test_masses
    place = first.position_m + np.array([apart, 0.3, 0.0])
    beside = DynamicTestMass(second.name, second.mass_kg, second.inertia_kg_m2, place, second.axes)
    with pytest.raises(PhysicsError, match="at one x"):
        actuation(Plant(plant.spacecraft, [first, beside], plant.fixed, plant.mutual))


def test_actuation_makes_the_accelerations_that_are_demanded() -> None:
    """Of a satellite with nothing aligned: housings by thrusters, test masses by suspension, turns about the middle."""
    plant = askew_plant(3)
    d = actuation(plant)
    sc, n = plant.spacecraft, len(DRAG_FREE)
    moved = np.concatenate([d[0:3, :n] / sc.mass_kg, np.linalg.solve(sc.inertia_kg_m2, d[3:6, :n])])
    rows = [COORDINATES.index(name) - 3 for name in DRAG_FREE]
    # the coordinate is that of the test mass in its housing, which moves the other way; u = -D v
    np.testing.assert_allclose((plant.housing @ moved)[rows], -np.eye(n), atol=1e-12)
    assert not d[6:, :n].any()
    acceleration = plant.inverse_mass @ d[6:]
    for k, name in enumerate(SUSPENSION, start=n):
        wanted = np.zeros(12)
        wanted[COORDINATES.index("TM2_x" if name == "x12" else name) - 3] = 1.0
        np.testing.assert_allclose(acceleration[:, k], wanted, atol=1e-15)
    middle = np.mean([tm.position_m for tm in plant.test_masses], axis=0)
    for axis in range(3):
        v = np.eye(3)[axis]
        wanted = np.zeros(12)
        for i, tm in enumerate(plant.test_masses):
            wanted[6 * i + 1 : 6 * i + 3] = (tm.axes @ np.cross(v, tm.position_m - middle))[1:]
        wanted[3] = plant.test_masses[0].axes[0] @ v
        np.testing.assert_allclose(acceleration[:, n + len(SUSPENSION) + axis], wanted, atol=1e-12)


def test_the_nominal_controller_holds_other_satellites() -> None:
    """40 plants: mass ± 15 %, inertia ± 10 %, centre ± 20 mm, stiffness -1.5 to 1.5 times LPF's with cross terms."""
    rng = np.random.default_rng(3)
    nominal = example_plant()
    gains = actuation(nominal)
    total = np.array([1.9e-6, 2.8e-6, 4.7e-6, 5.5e-6, 5.3e-6, 4.0e-6])
    for _ in range(40):
        sc = nominal.spacecraft
        body = Spacecraft(
            sc.mass_kg * rng.uniform(0.85, 1.15),
            sc.inertia_kg_m2 * rng.uniform(0.9, 1.1),
            sc.centre_of_mass_m + rng.uniform(-0.02, 0.02, 3),
        )
        fixed = rng.uniform(-1.5, 1.5, (2, 6))[:, :, None] * np.diag(total) + 0.1 * rng.normal(size=(2, 6, 6)) * 1e-6
        plant = Plant(body, nominal.test_masses, fixed, nominal.mutual)
        controller = ScalarLoops(plant, default_loops())
        controller.__dict__["actuation"] = gains  # as computed for the nominal satellite
        found = stability(plant, controller)
        assert found.largest_real_part < -1e-5
        assert min(m.phase_deg for m in found.margins) > 35.0


def test_a_sampled_controller_with_a_delay_comes_to_the_continuous_one_with_it() -> None:
    plant = example_plant()
    s = undelayed(plant).state_space()
    late = StateSpaceController(StateSpace(s.a, s.b, -s.c, -s.d), COORDINATES, INPUTS, delay_s=0.3)
    a, b, c, d, _ = signal.cont2discrete((s.a, s.b, -s.c, -s.d), 0.02, "bilinear")
    sampled = StateSpaceController(StateSpace(a, b, c, d), COORDINATES, INPUTS, delay_s=0.3, dt_s=0.02)
    ours, wanted = stability(plant, sampled), stability(plant, late)
    assert ours.largest_real_part == pytest.approx(wanted.largest_real_part, rel=0.01)
    # the poles of the controlled motion, some rad/s and slower; those of the roll-off and the delay are faster
    for pole in wanted.poles[np.abs(wanted.poles) < 0.5]:
        assert np.abs(ours.poles - pole).min() < 0.05 * abs(pole)


def test_margins_of_a_loop_that_crosses_many_times(monkeypatch: pytest.MonkeyPatch) -> None:
    """Gain and phase are crossed several times: the margins are those of python-control that are nearest to -1."""
    s = control.tf("s")
    loop = 2.0 * (s + 0.25) ** 2 / s**3 / (1.0 + s / 19.0) ** 3  # margins on both sides
    loop *= (s**2 / 0.81 + 0.08 * s / 0.9 + 1.0) / (s**2 / 0.64 + 0.08 * s / 0.8 + 1.0)  # resonances between them
    loop *= (s**2 + 0.006 * s + 0.0036) / (s**2 + 0.006 * s + 1.7 * 0.0036)

    def transfer(plant: object, controller: Controller | None, f: np.ndarray) -> np.ndarray:
        value = np.atleast_1d(loop(2j * np.pi * f))
        return (value / (1.0 + value))[:, None]

    monkeypatch.setattr(stability_room, "loop_transfer", transfer)
    f = np.geomspace(1e-5, 10.0, 3000)
    plant = example_plant()
    ours = stability_room._margins_of(plant, controlled(plant), 0, "x", f, transfer(None, None, f)[:, 0])
    gains, phases, _, _, crossed, _ = control.stability_margins(loop, returnall=True)
    more, less = gains[gains > 1.0], gains[gains < 1.0]
    assert min(len(more), len(less), len(crossed)) > 1
    assert ours.gain_db == pytest.approx(20.0 * np.log10(more.min()), abs=1e-4)
    assert ours.reduction_db == pytest.approx(20.0 * np.log10(less.max()), abs=1e-4)
    assert ours.crossover_hz == pytest.approx(crossed.max() / 2.0 / np.pi, rel=1e-6)
    assert ours.phase_deg == pytest.approx(np.abs((phases + 180.0) % 360.0 - 180.0).min(), abs=1e-4)


def test_python_control_agrees() -> None:
    """The loop closed by an independent library, at single frequencies."""
    plant = example_plant()
    motion = np.zeros((30, 30))
    motion[:15, 15:], motion[15:, :15] = np.eye(15), plant.K
    forced = np.zeros((30, 18))
    forced[15:] = plant.E
    body = control.ss(motion, forced, np.eye(15, 30), np.zeros((15, 18)))
    k = controlled(plant).state_space()
    closed = control.feedback(body, control.ss(k.a, k.b, k.c, k.d), sign=-1)
    response = np.moveaxis(closed.frequency_response(2 * np.pi * F).complex, 2, 0)
    ours = transfer(plant, controlled(plant))[:, :15, :18]
    size = np.abs(ours).max(axis=(0, 1), keepdims=True)
    np.testing.assert_allclose(response / size, ours / size, atol=1e-9)


def test_modes_of_a_sampled_loop_are_those_of_its_steps() -> None:
    plant = example_plant()
    s = undelayed(plant).state_space()
    a, b, c, d, _ = signal.cont2discrete((s.a, s.b, -s.c, -s.d), 0.1, "bilinear")
    controller = StateSpaceController(StateSpace(a, b, c, d), COORDINATES, INPUTS, dt_s=0.1)
    step = one_period(plant, controller)
    assert np.abs(np.linalg.eigvals(step)).max() < 1.0
    free = linalg.expm(0.1 * np.block([[np.zeros((15, 15)), np.eye(15)], [plant.K, np.zeros((15, 15))]]))
    off = StateSpaceController(StateSpace(a, b, 0.0 * c, 0.0 * d), COORDINATES, INPUTS, dt_s=0.1)
    late = replace(off, delay_s=0.05)  # its states come after the motion
    for controller in (off, late):
        np.testing.assert_allclose(one_period(plant, controller)[:30, :30], free, rtol=1e-12, atol=1e-12)


def test_a_sign_of_rounding_is_a_crossing_at_the_point_nearer_to_zero() -> None:
    """What many evaluations at once and a single one disagree on by rounding is not handed to a bracketing search."""
    grid, values = np.array([0.0, 1.0, 2.0]), np.array([1e-17, -1e-17, 2.0])
    found = stability_room._crossings(grid, values, lambda v: 3.0 * v - 4.0 if v >= 1.0 else -1e-17)
    assert found == [0.0, pytest.approx(4.0 / 3.0)]
