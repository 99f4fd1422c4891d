"""Laws that the closed loop must keep, whatever the satellite."""

from __future__ import annotations

import numpy as np
import pytest
from dynamics_models import askew_plant, controlled, example_plant, random_thermal
from scipy import integrate, linalg

from tedm_cli.dynamics.bodies import DynamicTestMass, cross_matrix
from tedm_cli.dynamics.budget import budget
from tedm_cli.dynamics.closed_loop import loop_transfer, responses
from tedm_cli.dynamics.controller import Controller, ScalarLoops, default_loops
from tedm_cli.dynamics.loops import Loop
from tedm_cli.dynamics.plant import Plant
from tedm_cli.dynamics.signals import COORDINATES, DISTURBANCES, INPUTS, OUTPUTS, STRAY
from tedm_cli.dynamics.sources import NoiseSource, PowerLaw, SpectrumTable
from tedm_cli.dynamics.state_space import loop_system
from tedm_cli.dynamics.thermal_input import ThermalInput

F = np.geomspace(1e-4, 0.3, 15)
S = 2j * np.pi * F


def transfer(plant: Plant, controller: Controller | None, f: np.ndarray = F) -> np.ndarray:
    return np.concatenate([h for _, h in responses(plant, controller, f)])


def out(h: np.ndarray, *labels: str) -> np.ndarray:
    return h[:, [OUTPUTS.index(label) for label in labels]]


def by(h: np.ndarray, *names: str) -> np.ndarray:
    return h[..., [DISTURBANCES.index(name) for name in names]]


def effort(plant: Plant, h: np.ndarray) -> np.ndarray:
    """[F, 1, 45]: largest acceleration that a single command or disturbance makes, before they cancel each other."""
    control = controlled(plant)
    gain = np.abs(control.command(S) @ control.returns)
    measured = np.abs(out(h, *COORDINATES))
    measured[:, :, len(INPUTS) : len(INPUTS) + len(COORDINATES)] += np.eye(len(COORDINATES))
    u = gain @ measured
    u[:, :, : len(INPUTS)] += np.eye(len(INPUTS))
    u[:, 6:, -len(STRAY) :] += plant.generalised_mass
    return (np.abs(plant.housing) @ np.abs(plant.spacecraft_response) @ u).max(axis=1, keepdims=True)


PLANTS = {"example": example_plant(), "askew": askew_plant(), "askew 2": askew_plant(5)}


@pytest.mark.parametrize("name", PLANTS)
def test_momentum(name: str) -> None:
    """m_B a_B + Σ m_i C_i a_i is the thrust, commanded and noise; what acts between the bodies cancels."""
    plant = PLANTS[name]
    plant = Plant(plant.spacecraft, plant.test_masses, plant.fixed, np.zeros((12, 12)))  # mutual gravity is of a field
    h = transfer(plant, controlled(plant))
    momentum = plant.spacecraft.mass_kg * out(h, "SC_a_x", "SC_a_y", "SC_a_z")
    for tm in plant.test_masses:
        part = tm.mass_kg * tm.to_basic @ out(h, *(f"{tm.name}_a_{axis}" for axis in "xyz"))
        momentum = momentum + part
    thrust = out(h, "u_SC_Fx", "u_SC_Fy", "u_SC_Fz").copy()
    for row, force in enumerate(("Fx", "Fy", "Fz")):
        thrust[:, row, DISTURBANCES.index(f"w_SC_{force}")] += 1.0
    assert (np.abs(momentum - thrust) <= 1e-14 * plant.spacecraft.mass_kg * effort(plant, h)).all()


@pytest.mark.parametrize("name", PLANTS)
def test_angular_momentum(name: str) -> None:
    """About the spacecraft's centre: I_B ω' + Σ C_i I_i ω_i' + Σ h_i × m_i C_i a_i is the torque of the thrusters."""
    plant = PLANTS[name]
    plant = Plant(plant.spacecraft, plant.test_masses, plant.fixed, np.zeros((12, 12)))
    h = transfer(plant, controlled(plant))
    total = plant.spacecraft.inertia_kg_m2 @ out(h, *(f"SC_omegadot_{axis}" for axis in "xyz"))
    for tm, lever in zip(plant.test_masses, plant.lever_m, strict=True):
        c = tm.to_basic
        spin = c @ tm.inertia_kg_m2 @ out(h, *(f"{tm.name}_omegadot_{axis}" for axis in "xyz"))
        orbit = cross_matrix(lever) @ (tm.mass_kg * c @ out(h, *(f"{tm.name}_a_{axis}" for axis in "xyz")))
        total = total + spin + orbit
    torque = out(h, "u_SC_Lx", "u_SC_Ly", "u_SC_Lz").copy()
    for row, name_of in enumerate(("Lx", "Ly", "Lz")):
        torque[:, row, DISTURBANCES.index(f"w_SC_{name_of}")] += 1.0
    assert (np.abs(total - torque) <= 1e-14 * plant.spacecraft.mass_kg * effort(plant, h)).all()


@pytest.mark.parametrize("name", PLANTS)
def test_acceleration_is_that_of_the_housing_and_the_motion_in_it(name: str) -> None:
    plant = PLANTS[name]
    h = transfer(plant, controlled(plant))
    for i, tm in enumerate(("TM1", "TM2"), start=1):
        relative = (S**2)[:, None, None] * out(h, *(f"{tm}_{axis}" for axis in "xyz"))
        housing, inertial = (out(h, *(f"{body}_a_{axis}" for axis in "xyz")) for body in (f"H{i}", tm))
        moved = np.abs(S**2)[:, None, None] * np.abs(out(h, *COORDINATES)).max(
            axis=1, keepdims=True
        )  # 1 m beside 1 rad
        size = effort(plant, h) + moved
        assert (np.abs(inertial - relative - housing) <= 1e-13 * size).all()


def aligned() -> Plant:
    """The example with another mutual gravity and a difference of stiffness in every direction."""
    plant = example_plant()
    return Plant(plant.spacecraft, plant.test_masses, plant.fixed * np.array([1.0, 1.3])[:, None, None], plant.mutual)


def slower(plant: Plant) -> ScalarLoops:
    """Another stable controller."""
    return ScalarLoops(plant, [Loop(x.name, 0.6 * x.crossover_hz, 0.5 * x.delay_s) for x in default_loops()])


@pytest.mark.parametrize("make", [controlled, slower])
def test_delta_g_full_of_temperature_does_not_feel_the_controller(make) -> None:
    """[S_x2 - S_x1 - ω² (N_x2 - N_x1) - κ N] ΔT, for aligned test masses and any stable controller."""
    plant = aligned()
    h = out(transfer(plant, make(plant)), "delta_g_full")[:, 0]
    kappa = plant.total_stiffness[6] - plant.total_stiffness[0]
    for name in STRAY:
        wanted = {"TM2_a_x": 1.0, "TM1_a_x": -1.0}.get(name, 0.0)
        got = by(h, f"s_{name}")[:, 0]
        scale = 1.0 if "_a_" in name else plant.generalised_mass[3, 3] / plant.generalised_mass[0, 0]
        assert np.abs(got - wanted).max() < 1e-9 * max(1.0, 1.0 / scale) * (1.0 if wanted else 1e-3), name
    for column, coordinate in enumerate(COORDINATES):
        wanted = -kappa[column - 3] if column >= 3 else 0.0
        factor = {"TM2_x": S**2, "TM1_x": -(S**2)}.get(coordinate, 0.0 * S)
        got = by(h, f"n_{coordinate}")[:, 0]
        size = np.abs(S**2) + np.abs(kappa).max()
        assert (np.abs(got - (factor + wanted)) < 1e-9 * size).all(), coordinate


@pytest.mark.parametrize("name", PLANTS)
def test_differential_accelerations_are_made_of_the_other_outputs(name: str) -> None:
    """o12'' less what is commanded and what stiffness makes; the true one is of the forces that act, noise included."""
    plant = PLANTS[name]
    h = transfer(plant, controlled(plant))
    m1, m2 = (tm.mass_kg for tm in plant.test_masses)
    x1, x2 = (out(h, f"meas_{tm}_x")[:, 0] for tm in ("TM1", "TM2"))
    command = out(h, "u_TM2_Fx")[:, 0] / m2 - out(h, "u_TM1_Fx")[:, 0] / m1
    kappa = plant.total_stiffness[6] - plant.total_stiffness[0]
    free = (S**2)[:, None] * (x2 - x1) - command
    all_motion = np.einsum("k,fkd->fd", kappa, out(h, *(f"meas_{c}" for c in COORDINATES[3:])))
    wanted = {"delta_g": free - kappa[6] * x2 - kappa[0] * x1, "delta_g_full": free - all_motion}
    for label, one in wanted.items():
        size = np.abs(free).max(axis=1, keepdims=True) + np.abs(one)
        assert (np.abs(out(h, label)[:, 0] - one) <= 1e-12 * size).all(), label
    true = np.zeros(len(DISTURBANCES))
    true[[DISTURBANCES.index(n) for n in ("s_TM1_a_x", "s_TM2_a_x", "w_TM1_Fx", "w_TM2_Fx")]] = -1, 1, -1 / m1, 1 / m2
    np.testing.assert_allclose(out(h, "delta_g_true")[:, 0], np.broadcast_to(true, (len(F), len(true))), rtol=1e-14)


def test_delta_g_true_of_gravity_alone() -> None:
    plant = example_plant()
    thermal = random_thermal(4, F)
    alone = ThermalInput(thermal.acceleration, np.zeros_like(thermal.read_out), thermal.factor, thermal.amplitude)
    found = budget(plant, controlled(plant), [], alone, F, ["delta_g_true"])
    rows = thermal.acceleration[STRAY.index("TM2_a_x")] - thermal.acceleration[STRAY.index("TM1_a_x")]
    np.testing.assert_allclose(found.total[:, 0], ((rows[:, None] * thermal.amplitude) ** 2).sum(axis=0), rtol=1e-13)
    np.testing.assert_allclose(found.gravity, found.thermal, rtol=1e-13)


def test_gravity_and_read_out_apart_are_two_budgets() -> None:
    """What cancels in the sum of both does not in the sum of their powers; either alone is its own budget."""
    plant, both = example_plant(), random_thermal(5, F)
    control = controlled(plant)
    nothing = (np.zeros_like(both.acceleration), np.zeros_like(both.read_out))
    gravity = ThermalInput(both.acceleration, nothing[1], both.factor, both.amplitude)
    read_out = ThermalInput(nothing[0], both.read_out, both.factor, both.amplitude)
    opposite = ThermalInput(both.acceleration, -both.read_out, both.factor, both.amplitude)
    whole, one, two, other = (budget(plant, control, [], t, F) for t in (both, gravity, read_out, opposite))
    np.testing.assert_allclose(whole.gravity, one.thermal, rtol=1e-12)
    np.testing.assert_allclose(whole.incoherent, one.thermal + two.thermal, rtol=1e-12)
    np.testing.assert_allclose(whole.thermal + other.thermal, 2.0 * whole.incoherent, rtol=1e-9)


def test_free_test_masses_follow_gravity() -> None:
    """Without control and stiffness ω² x12 is the differential acceleration, less what turning adds."""
    plant = example_plant()
    free = Plant(plant.spacecraft, plant.test_masses, np.zeros((2, 6, 6)), np.zeros((12, 12)))
    h = transfer(free, None)
    x12 = (S**2)[:, None] * (out(h, "TM2_x") - out(h, "TM1_x"))[:, 0]
    true = out(h, "delta_g_true")[:, 0]
    for name in ("s_TM1_a_x", "s_TM2_a_x"):
        # both test masses pull on the spacecraft off its centre, which turns by some 1e-4 of what they move
        np.testing.assert_allclose(by(x12, name), by(true, name), rtol=1e-12)


def test_read_out_noise_in_delta_g_full() -> None:
    """-(ω² + κ_x2) n of o12 alone, -(κ_x1 + κ_x2) n of o1 alone."""
    plant = aligned()
    h = out(transfer(plant, controlled(plant)), "delta_g_full")[:, 0]
    kappa = plant.total_stiffness[6] - plant.total_stiffness[0]
    o12, both = by(h, "n_TM2_x")[:, 0], by(h, "n_TM1_x", "n_TM2_x").sum(axis=1)
    np.testing.assert_allclose(o12, -(np.abs(S) ** 2 + kappa[6]), rtol=1e-8)
    # noise of o1 is in both read-outs of x
    np.testing.assert_allclose(both, -(kappa[0] + kappa[6]) * np.ones(len(F)), rtol=1e-6, atol=1e-12)


def test_delta_g_full_is_blind_to_the_spacecraft() -> None:
    plant = aligned()
    h = transfer(plant, controlled(plant))
    full, simple = out(h, "delta_g_full")[:, 0], out(h, "delta_g")[:, 0]
    a_sc = np.abs(out(h, "SC_a_x")[:, 0])
    for name in ("SC_Fx", "SC_Fy", "SC_Fz"):
        assert (np.abs(by(full, f"w_{name}")[:, 0]) < 1e-9 * by(a_sc, "w_SC_Fx")[:, 0]).all()
    assert np.abs(by(simple, "w_SC_Fz")).max() > 1e3 * np.abs(by(full, "w_SC_Fz")).max()  # by cross stiffness


def test_equal_stiffness_leaves_x12_blind_to_thrusters() -> None:
    plant = example_plant()
    fixed = np.repeat(np.diag([1.0, 2.0, 3.0, 4.0, 5.0, 6.0])[None] * 1e-6, 2, axis=0)
    equal = Plant(plant.spacecraft, plant.test_masses, fixed, np.zeros((12, 12)))
    h = transfer(equal, controlled(equal))
    x1, x2 = (by(out(h, label)[:, 0], "w_SC_Fx")[:, 0] for label in ("TM1_x", "TM2_x"))
    assert (np.abs(x2 - x1) < 1e-9 * np.abs(x1)).all()


@pytest.mark.parametrize("name", PLANTS)
def test_sensitivity_and_its_complement(name: str) -> None:
    """p by n is -T, y by n is S, S + T = 1; loops by rows: T_j of the loop is the diagonal of T."""
    plant = PLANTS[name]
    h = transfer(plant, controlled(plant))
    noise = [f"n_{c}" for c in COORDINATES]
    p, y = by(out(h, *COORDINATES), *noise), by(out(h, *(f"meas_{c}" for c in COORDINATES)), *noise)
    np.testing.assert_allclose(y - p, np.broadcast_to(np.eye(15), y.shape), atol=1e-9)
    loops = loop_transfer(plant, controlled(plant), F)
    own = controlled(plant).loops.index("TM1_y")
    at = COORDINATES.index("TM1_y")
    np.testing.assert_allclose(loops[:, own], -p[:, at, at], rtol=1e-9)


def test_slow_noise_is_followed_and_fast_noise_ignored() -> None:
    plant = example_plant()
    slow, fast = (transfer(plant, controlled(plant), np.array([f])) for f in (1e-4, 30.0))
    assert by(out(slow, "TM1_x")[0, 0], "n_TM1_x")[0] == pytest.approx(-1.0, abs=1e-3)
    open_loop = transfer(plant, None, np.array([30.0]))
    np.testing.assert_allclose(by(out(fast, "TM1_x"), "w_SC_Fx"), by(out(open_loop, "TM1_x"), "w_SC_Fx"), rtol=1e-3)


def test_integral_action() -> None:
    """A constant force on the spacecraft is taken up by the thrusters; the motion falls with f."""
    plant = example_plant()
    f = np.array([1e-6, 1e-5])
    h = transfer(plant, controlled(plant), f)
    motion = np.abs(by(out(h, "TM1_x")[:, 0], "w_SC_Fx")[:, 0])
    assert motion[1] / motion[0] == pytest.approx(10.0, rel=0.05)
    assert by(out(h, "u_SC_Fx")[0, 0], "w_SC_Fx")[0] == pytest.approx(-1.0, abs=1e-2)


def test_power_grows_with_the_square_of_the_level() -> None:
    plant = example_plant()
    one, three = (
        budget(plant, controlled(plant), [NoiseSource("a", "a", {"w_SC_Fx": 1.0}, PowerLaw(level, 1e-3, 2.0))], None, F)
        for level in (1e-7, 3e-7)
    )
    np.testing.assert_allclose(three.total, 9.0 * one.total, rtol=1e-13)
    points = np.array([1e-5, 1.0])
    table = SpectrumTable(tuple(points), tuple(1e-7 * (points / 1e-3) ** -1.0), "table")
    np.testing.assert_allclose(table.psd(F), (1e-7 * 1e-3 / F) ** 2, rtol=1e-12)


def test_parts_of_uncorrelated_areas_add_up() -> None:
    """Case 2 is case 6 and case 8 together; correlated areas do not add: shares are signed and sum to the whole."""
    plant, thermal = example_plant(), random_thermal(6, F)

    def part(members: list[int], factor: np.ndarray) -> ThermalInput:
        return ThermalInput(
            thermal.acceleration[:, members], thermal.read_out[:, members], factor, thermal.amplitude[members]
        )

    control = controlled(plant)
    whole = budget(plant, control, [], part([*range(6)], np.eye(6)), F, areas_of=OUTPUTS)
    halves = [budget(plant, control, [], part(m, np.eye(3)), F) for m in ([0, 1, 2], [3, 4, 5])]
    np.testing.assert_allclose(whole.total, halves[0].total + halves[1].total, rtol=1e-12)
    for o, label in enumerate(OUTPUTS):
        np.testing.assert_allclose(whole.area[label].sum(axis=1), whole.total[:, o], rtol=1e-12)
    some = OUTPUTS[::-7]
    phases = np.exp(2j * np.pi * np.linspace(0.0, 1.0, 12)).reshape(6, 2)  # areas that follow each other
    turned = budget(plant, control, [], part([*range(6)], phases), F, areas_of=some)
    for label, area in turned.area.items():
        np.testing.assert_allclose(area.sum(axis=1), turned.total[:, OUTPUTS.index(label)], rtol=1e-9)
    together = budget(plant, control, [], part([*range(6)], np.ones((6, 1))), F, areas_of=some)
    assert list(together.area) == list(some)
    for label, area in together.area.items():
        rms, total = np.abs(area).sum(axis=1), together.total[:, OUTPUTS.index(label)]
        assert (np.abs(area.sum(axis=1) - total) <= 1e-12 * rms).all(), label
        assert (area < 0.0).any(), label


@pytest.mark.parametrize("name", PLANTS)
def test_state_space_is_the_loop_at_single_frequencies(name: str) -> None:
    plant = PLANTS[name]
    control = controlled(plant)
    direct, system = transfer(plant, control), loop_system(plant, control).response(S)
    # weighted as noise is: by what each disturbance does to the output
    weight = np.array([{"w": 1e-7, "n": 1e-9, "s": 1e-14}[name[0]] for name in DISTURBANCES])
    size = np.sqrt((np.abs(direct * weight) ** 2).sum(axis=2))
    error = np.sqrt((np.abs((direct - system) * weight) ** 2).sum(axis=2))
    assert (error <= 1e-9 * size).all()


def test_variance_by_lyapunov_is_the_integral_of_the_spectrum() -> None:
    """∫PSD df of x1 under thruster noise = its variance of A P + P Aᵀ + B Bᵀ / 2 = 0."""
    plant = example_plant()
    control = controlled(plant)
    system = loop_system(plant, control).system
    b = 2.4e-7 * system.b[:, [DISTURBANCES.index("w_SC_Fx")]]
    variance = linalg.solve_continuous_lyapunov(system.a, -b @ b.T / 2.0)
    f = np.geomspace(1e-7, 100.0, 6000)
    source = NoiseSource("thruster", "thruster", {"w_SC_Fx": 1.0}, PowerLaw(2.4e-7))
    psd = budget(plant, control, [source], None, f, ["TM1_x"]).total[:, 0]
    x1 = COORDINATES.index("TM1_x")
    np.testing.assert_allclose(integrate.trapezoid(psd, f), variance[x1, x1], rtol=1e-3)


def test_inputs_and_names() -> None:
    assert len(OUTPUTS) == 75
    assert len(DISTURBANCES) == 45
    assert len(INPUTS) == 18
    plant = askew_plant()
    assert isinstance(plant.test_masses[0], DynamicTestMass)
    np.testing.assert_allclose(np.linalg.eigvalsh(plant.eighteen()[0]).min() > 0, True)
