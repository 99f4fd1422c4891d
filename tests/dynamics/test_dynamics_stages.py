"""build-dynamics and simulate on the small sample: what their files hold, recomputed from them and from the inputs."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from border_tools import Project, replace
from scipy import signal
from scipy.io import savemat

from tedm_cli.contracts import DYNAMICS, SIMULATION
from tedm_cli.dynamics.controller import LOOPS
from tedm_cli.dynamics.signals import COORDINATES, INPUTS, OUTPUTS
from tedm_cli.files.store import open_checked
from tedm_cli.results.dynamics.loop import read_simulation

LPF_TOTALS = [1.9e-6, 2.8e-6, 4.7e-6, 5.5e-6, 5.3e-6, 4.0e-6]


def held(path: Path, *names: str) -> list[Any]:
    """Datasets of a file."""
    with h5py.File(path) as file:
        return [file[name].asstr()[()] if file[name].dtype.kind in "OS" else file[name][()] for name in names]


def psds(path: Path) -> dict[str, np.ndarray]:
    with h5py.File(path) as file:
        return {name: file[f"psd/{name}"][()] for name in OUTPUTS}


def parts(path: Path, group: str) -> np.ndarray:
    """[75, F], the part of a group in every output."""
    with h5py.File(path) as file:
        return np.stack([file[f"contribution/{group}/{name}"][()] for name in OUTPUTS])


def configured(project: Project, text: str) -> Project:
    (project.folder / "dynamics.toml").write_text(text)
    project.run("build-dynamics").ok()
    return project


def test_files_obey_their_contracts(built: Project) -> None:
    with open_checked(built.build / "dynamics.h5", DYNAMICS), open_checked(built.build / "simulation03.h5", SIMULATION):
        pass


def test_matrices_of_both_forms_agree(built: Project) -> None:
    mass, k, u, k_p, e = held(built.build / "dynamics.h5", "matrix/M", "matrix/K", "matrix/U", "matrix/K_p", "matrix/E")
    assert (np.linalg.eigvalsh((mass[:3, :3] + mass[:3, :3].T) / 2) > 0.0).all()
    for reduced, whole in ((k_p, np.linalg.solve(mass, k)[3:, 3:]), (e, np.linalg.solve(mass, u)[3:])):
        size = np.abs(reduced).max(axis=1, keepdims=True) + 1e-300
        np.testing.assert_allclose(whole / size, reduced / size, atol=1e-12)
    assert np.abs(k[:, :3]).max() == 0.0, "where the spacecraft is moves nothing"


def test_defaults_and_stiffness_by_source(built: Project) -> None:
    path = built.build / "dynamics.h5"
    weight, inertia, source, by_source, mutual, position, com = held(
        path, "spacecraft/mass", "spacecraft/inertia", "stiffness/source", "stiffness/by_source", "stiffness/mutual",
        "test_mass/position", "spacecraft/centre_of_mass",
    )  # fmt: skip
    assert weight == 422.7
    np.testing.assert_array_equal(inertia, np.diag([202.5, 209.7, 191.7]))
    np.testing.assert_allclose(position.mean(axis=0) - com, [0.005, 0.006, 0.1393], atol=1e-12)
    total = by_source.sum(axis=1)
    np.testing.assert_allclose(np.diagonal(total, axis1=1, axis2=2), [LPF_TOTALS] * 2, rtol=1e-12)
    # with the other test mass: gravity's linearised stiffness, which sensitivity.h5 holds as a whole
    assert source[-1] == "electrostatics"
    (linearised,) = held(built.build / "sensitivity.h5", "stiffness/linearised")
    without = by_source[:, :-1].sum(axis=1)
    whole = np.zeros((12, 12))
    whole[:6, :6], whole[6:, 6:] = without
    np.testing.assert_allclose(whole + mutual, linearised, atol=1e-12 * np.abs(linearised).max())
    # each source by its blocks: force and torque by displacement and rotation
    names = held(built.build / "sensitivity.h5", "source/name")[0].tolist()
    for s, name in enumerate(source[:-1]):
        for block, rows, columns in (
            ("gamma_lin", slice(0, 3), slice(0, 3)), ("gamma_ang", slice(0, 3), slice(3, 6)),
            ("omega_lin", slice(3, 6), slice(0, 3)), ("omega_ang", slice(3, 6), slice(3, 6)),
        ):  # fmt: skip
            (wanted,) = held(built.build / "sensitivity.h5", f"stiffness/{block}")
            np.testing.assert_array_equal(by_source[:, s, rows, columns], wanted[:, names.index(name)])


def test_both_test_masses_moved_alike_pull_at_each_other_as_before(built: Project) -> None:
    """The stiffness that acts back on nothing is all of the other test mass: that of the spacecraft is not in it."""
    (mutual,) = held(built.build / "dynamics.h5", "stiffness/mutual")
    pull = np.abs(mutual[:3, 6:9]).max()
    assert pull > 1e-9
    for own, other in ((slice(0, 3), slice(6, 9)), (slice(6, 9), slice(0, 3))):
        np.testing.assert_allclose(mutual[own, own] + mutual[own, other], 0.0, atol=1e-5 * pull)


def test_test_masses_are_those_of_the_sensitivities(built: Project) -> None:
    """Moments of cuboids, and what pulls at rest: all sources together, test mass by test mass."""
    moments, at_rest = held(built.build / "dynamics.h5", "test_mass/inertia", "test_mass/at_rest")
    mass, side, linear, angular = held(
        built.build / "sensitivity.h5", "test_mass/mass", "test_mass/side", "dc/acceleration", "dc/angular_acceleration"
    )
    squares = side**2
    for i in (0, 1):
        for k in range(3):
            across = [squares[i, (k + 1) % 3], squares[i, (k + 2) % 3]]
            np.testing.assert_allclose(moments[i, k], np.eye(3)[k] * mass[i] / 12.0 * sum(across), rtol=1e-12)
        pull = np.concatenate([linear[i].sum(axis=0), angular[i].sum(axis=0)])
        np.testing.assert_allclose(at_rest[6 * i : 6 * i + 6], pull, rtol=1e-12, atol=1e-30)


def test_poles_are_those_of_the_system(built: Project) -> None:
    a, real, imaginary = held(built.build / "dynamics.h5", "system/A", "pole/real", "pole/imaginary")
    poles = real + 1j * imaginary
    assert (np.diff(real) <= 0.0).all(), "the slowest come first"
    wanted = np.linalg.eigvals(a)
    assert max(np.abs(poles - z).min() for z in wanted) < 1e-6
    assert max(np.abs(wanted - z).min() for z in poles) < 1e-6


def test_open_loops_of_the_file(built: Project) -> None:
    """L = T / (1 - T): of gain 1 at the crossover that is told, with the phase margin that is told, at the highest."""
    names, f, crossover, phase, real, imaginary = held(
        built.build / "dynamics.h5", "loop/name", "loop/frequency", "loop/crossover", "loop/phase_margin",
        "loop/open_real", "loop/open_imaginary",
    )  # fmt: skip
    for j, name in enumerate(names):
        at = np.log(crossover[j])
        gain = np.interp(at, np.log(f), np.log(np.hypot(real[j], imaginary[j])))
        assert abs(gain) < 2e-3, name
        angle = np.interp(at, np.log(f), np.unwrap(np.arctan2(imaginary[j], real[j])))
        margin = abs((np.degrees(angle) + 360.0) % 360.0 - 180.0)
        assert abs(margin - phase[j]) < 0.1, name


def test_what_a_file_says_is_obeyed(satellite: Project) -> None:
    configured(
        satellite,
        """
        [spacecraft]
        mass_kg = 500.0
        inertia_matrix_kg_m2 = [[300.0, 5.0, 0.0], [5.0, 310.0, -2.0], [0.0, -2.0, 290.0]]
        centre_of_mass_m = [0.01, 0.02, -0.1]
        [read_out]
        set = "B"
        [[controller.loop]]
        name = "x12"
        crossover_hz = 5e-4
        """,
    )
    satellite.run("simulate", "3").ok()
    path = satellite.build / "dynamics.h5"
    weight, inertia, com, names, crossover, heard = held(
        path, "spacecraft/mass", "spacecraft/inertia", "spacecraft/centre_of_mass", "loop/name", "loop/crossover",
        "read_out/set",
    )  # fmt: skip
    assert (weight, heard) == (500.0, "B")
    np.testing.assert_array_equal(inertia, [[300, 5, 0], [5, 310, -2], [0, -2, 290]])
    np.testing.assert_array_equal(com, [0.01, 0.02, -0.1])
    # of 1 mHz by default; against the stiffness the gain of 1 is met a little lower than without
    assert 3e-4 < crossover[list(names).index("x12")] < 5e-4
    assert held(satellite.build / "simulation03.h5", "read_out/set") == ["B"]


def test_electrostatics(satellite: Project) -> None:
    path = satellite.build / "dynamics.h5"
    configured(satellite, '[stiffness]\npreset = "none"\n')
    (none,) = held(path, "stiffness/by_source")
    assert not none[:, -1].any()
    six = [1e-6, 2e-6, 3e-6, 4e-6, 5e-6, 6e-6]
    configured(satellite, f"[stiffness.electrostatic]\nTM1 = {six}\nTM2 = {six[::-1]}\n")
    (diagonal,) = held(path, "stiffness/by_source")
    np.testing.assert_array_equal(diagonal[:, -1], [np.diag(six), np.diag(six[::-1])])
    np.testing.assert_array_equal(diagonal[:, :-1], none[:, :-1])
    own = (1e-7 * np.arange(72).reshape(2, 6, 6) / 36).tolist()
    configured(satellite, f"[stiffness.electrostatic_matrix]\nTM1 = {own[0]}\nTM2 = {own[1]}\n")
    (full,) = held(path, "stiffness/by_source")
    np.testing.assert_allclose(full[:, -1], own, rtol=1e-14)


def test_groups_sum_to_the_total_and_verdicts_to_their_tables(built: Project) -> None:
    path = built.build / "simulation03.h5"
    total = psds(path)
    groups, f, factor = held(path, "group/name", "frequency", "case/safety_factor")
    assert factor == 2.0
    summed = sum(parts(path, group) for group in groups)
    np.testing.assert_allclose(summed, np.stack(list(total.values())), rtol=1e-12)
    outputs, requirements, ratio, binding, passed, area, shares = held(
        path, "verdict/output", "verdict/requirement", "verdict/ratio", "verdict/binding_frequency", "verdict/passed",
        "verdict/area_share", "verdict/group_share",
    )  # fmt: skip
    names, limits = held(path, "requirement/name", "requirement/amplitude")
    for v, (output, requirement) in enumerate(zip(outputs, requirements, strict=True)):
        ratios = factor * np.sqrt(total[output]) / limits[list(names).index(requirement)]
        np.testing.assert_allclose(ratio[v], np.nanmax(ratios), rtol=1e-12)
        assert binding[v] == f[np.nanargmax(ratios)]
        assert passed[v] == (np.nanmax(ratios) <= 1.0)
        np.testing.assert_allclose(shares[v].sum(), 1.0, rtol=1e-12)
        np.testing.assert_allclose(area[v].sum(), shares[v, list(groups).index("thermal")], rtol=1e-9, atol=1e-15)


def test_limits_are_those_of_the_documents(built: Project) -> None:
    names, limits, f = held(built.build / "simulation03.h5", "requirement/name", "requirement/amplitude", "frequency")
    limit = dict(zip(names, limits, strict=True))
    lpf = 3e-14 * (1.0 + (f / 3e-3) ** 2)
    inside = (f >= 1e-3 * (1 - 1e-9)) & (f <= 0.03 * (1 + 1e-9))
    np.testing.assert_allclose(limit["lpf_acceleration"][inside], lpf[inside], rtol=1e-12)
    assert np.isnan(limit["lpf_acceleration"][~inside]).all()
    lisa = 3e-15 * np.sqrt(1.0 + (0.4e-3 / f) ** 2) * np.sqrt(1.0 + (f / 8e-3) ** 4)
    inside = np.isfinite(limit["lisa_acceleration"])
    np.testing.assert_allclose(limit["lisa_acceleration"][inside], lisa[inside], rtol=1e-12)
    np.testing.assert_allclose(limit["lisa_acceleration_differential"][inside], lisa[inside] * np.sqrt(2), rtol=1e-12)
    np.testing.assert_allclose(limit["lpf_jitter"][np.isfinite(limit["lpf_jitter"])], 5e-9, rtol=1e-12)


def test_temperatures_in_delta_g_full_without_the_loop(built: Project) -> None:
    """[S_x2 - S_x1 - ω² (N_x2 - N_x1) - κ N] ΔT, whatever the controller: S, N and stiffness from their files."""
    path = built.build / "simulation03.h5"
    f, chosen, shields = held(path, "frequency", "read_out/set", "area/shield")
    by_source, mutual = held(built.build / "dynamics.h5", "stiffness/by_source", "stiffness/mutual")
    s_label, s = held(built.build / "sensitivity.h5", "row/label", "S")
    n_label, n = held(built.build / "optics.h5", "label/read_out", f"N/{chosen}")
    stiffness = mutual.copy()
    stiffness[:6, :6] += by_source[0].sum(axis=0)
    stiffness[6:, 6:] += by_source[1].sum(axis=0)
    kappa = stiffness[6] - stiffness[0]
    read = np.zeros((12, n.shape[1]))
    for label, row in zip(n_label, n, strict=True):
        read[COORDINATES.index(label) - 3] = row
    gravity = dict(zip(s_label, s, strict=True))
    omega = 2.0 * np.pi * f[:, None]
    by_gravity = np.broadcast_to(gravity["TM2_a_x"] - gravity["TM1_a_x"], (len(f), n.shape[1]))
    by_read_out = -(omega**2) * (read[6] - read[0]) - kappa @ read
    low_pass = np.sqrt(2.0 / (1.0 + (f / 1e-3) ** 4))  # order 2, corner and reference 1 mHz, as in cases.toml

    def power(by_kelvin: np.ndarray) -> np.ndarray:
        """[F] in case 3: correlated outside the shield, and inside."""
        levels = {"outside": 1e-3, "inside": 1e-4}
        return sum((a * low_pass * by_kelvin[:, shields == name].sum(axis=1)) ** 2 for name, a in levels.items())

    thermal = parts(path, "thermal")[OUTPUTS.index("delta_g_full")]
    np.testing.assert_allclose(thermal, power(by_gravity + by_read_out), rtol=1e-8)
    alone, apart = held(path, "thermal/gravity/delta_g_full", "thermal/incoherent/delta_g_full")
    np.testing.assert_allclose(alone, power(by_gravity), rtol=1e-8)
    np.testing.assert_allclose(apart, power(by_gravity) + power(by_read_out), rtol=1e-8)
    assert (np.abs(apart / thermal - 1.0) > 0.1).any(), "phases count"


def test_a_louder_temperature_is_heard_as_its_square(satellite: Project) -> None:
    configured(satellite, "")
    satellite.run("simulate", "3").ok()
    path = satellite.build / "simulation03.h5"
    (groups,) = held(path, "group/name")
    before = {group: parts(path, group) for group in groups}
    replace(satellite.folder / "cases.toml", "outside_K = 1e-3", "outside_K = 2e-3")
    replace(satellite.folder / "cases.toml", "inside_K = 1e-4", "inside_K = 2e-4")
    satellite.run("simulate", "3").ok()
    for group in groups:
        np.testing.assert_allclose(parts(path, group), before[group] * (4.0 if group == "thermal" else 1.0), rtol=1e-12)


def test_delays_turn_phases_only_between_areas(satellite: Project) -> None:
    """All areas late alike change nothing; one group late changes the sum of the correlated ones."""
    configured(satellite, "")
    cases = satellite.folder / "cases.toml"
    cases.write_text(
        cases.read_text()
        + "".join(
            f'\n[[case]]\nid = "{n}"\ntitle = "x"\nblocks = [{{ areas = ["*"] }}]\n{delays}'
            for n, delays in (
                (91, ""),
                (92, 'delays = [{ areas = ["*"], delay_s = 700.0 }]\n'),
                (93, 'delays = [{ groups = ["IS1"], delay_s = 700.0 }]\n'),
            )
        )
    )
    satellite.run("simulate", "91", "92", "93").ok()
    together, late, apart = (parts(satellite.build / f"simulation{n}.h5", "thermal") for n in (91, 92, 93))
    np.testing.assert_allclose(late, together, rtol=1e-9)
    felt = OUTPUTS.index("delta_g_full")
    assert np.abs(apart[felt] / together[felt] - 1.0).max() > 1e-3


def test_all_cases(satellite: Project) -> None:
    """Twelve files that obey their contract, and one table of what decides: the largest ratio of a likely violation."""
    configured(satellite, "")
    said = satellite.run("simulate", "all").ok().out.splitlines()
    files = sorted(satellite.build.glob("simulation*.h5"))
    assert len(files) == 12
    found: dict[tuple[str, str], list[tuple[str, str, float, bool]]] = {}
    for path in files:
        with open_checked(path, SIMULATION) as file:
            case = read_simulation(file)
        for j in case.judged:
            found.setdefault((j.output, j.requirement), []).append((case.id, case.role, j.ratio, j.passed))
    table = [line.split() for line in said[said.index("in the case that decides") + 3 :]]
    assert [(row[0], row[1]) for row in table] == list(found)
    for row, verdicts in zip(table, found.values(), strict=True):
        likely = [v for v in verdicts if v[1] == "likely" and not v[3]]
        told = max(likely or [v for v in verdicts if v[1] != "diagnostic"], key=lambda v: v[2])
        assert float(row[4]) == float(f"{told[2]:.3g}")
        assert row[3] == told[1]
        assert row[7:10] == [str(sum(not v[3] for v in verdicts)), "of", "12"]


def test_a_controller_of_ones_own_that_is_the_default(satellite: Project) -> None:
    """The loops, here without delays, as a state space in each kind of file: the same spectra."""
    configured(satellite, "".join(f'[[controller.loop]]\nname = "{name}"\ndelay_s = 0.0\n' for name in LOOPS))
    satellite.run("simulate", "3").ok()
    path = satellite.build / "simulation03.h5"
    before = np.stack(list(psds(path).values()))
    a, b, c, d = held(satellite.build / "dynamics.h5", *(f"controller/{name}" for name in "ABCD"))
    arrays = {"A": a, "B": b, "C": c, "D": d}
    # names in another order than that of the file
    back = list(INPUTS)[::-1]
    turned = arrays | {"C": c[::-1], "D": d[::-1], "inputs": np.array(COORDINATES), "outputs": np.array(back)}
    np.savez(satellite.folder / "own.npz", **turned)
    cells = {"inputs": np.array(COORDINATES, dtype=object), "outputs": np.array(INPUTS, dtype=object)}
    savemat(satellite.folder / "own.mat", arrays | cells)
    text = [f"{name} = {value.tolist()}" for name, value in arrays.items()]
    text += [f"inputs = {json.dumps(list(COORDINATES))}", f"outputs = {json.dumps(list(INPUTS))}"]
    (satellite.folder / "own.toml").write_text("\n".join(text))
    for kind in ("npz", "mat", "toml"):
        configured(satellite, f'[controller]\nfile = "own.{kind}"\n')
        satellite.run("simulate", "3").ok()
        np.testing.assert_allclose(np.stack(list(psds(path).values())), before, rtol=1e-9)


def test_a_sampled_controller_of_ones_own(satellite: Project) -> None:
    """The loops without delays sampled at 20 Hz, late by 0.1 s: what the file says, and near the continuous one."""
    loops = "".join(f'[[controller.loop]]\nname = "{name}"\ndelay_s = 0.0\n' for name in LOOPS)
    configured(satellite, loops)
    path = satellite.build / "dynamics.h5"
    a, b, c, d = held(path, *(f"controller/{name}" for name in "ABCD"))
    a, b, c, d, _ = signal.cont2discrete((a, b, c, d), 0.05, "bilinear")
    names = {"inputs": np.array(COORDINATES), "outputs": np.array(INPUTS)}
    np.savez(satellite.folder / "own.npz", A=a, B=b, C=c, D=d, dt_s=0.05, delay_s=0.1, **names)
    configured(satellite, '[controller]\nfile = "own.npz"\n')
    period, delay, f, real = held(path, "controller/period", "controller/delay", "loop/frequency", "loop/open_real")
    assert (period, delay) == (0.05, 0.1)
    assert f[-1] <= 10.0
    assert real.shape == (15, len(f))
    with h5py.File(path) as file:
        assert "system" not in file, "no continuous system is a sampled loop"
    satellite.run("simulate", "3").ok()
    sampled = psds(satellite.build / "simulation03.h5")
    configured(satellite, loops.replace("delay_s = 0.0", "delay_s = 0.125"))  # with half a period of the hold
    satellite.run("simulate", "3").ok()
    continuous = psds(satellite.build / "simulation03.h5")
    for name in ("delta_g", "TM1_x", "TM2_y", "SC_theta"):
        np.testing.assert_allclose(sampled[name], continuous[name], rtol=0.02)


def test_sources_switched_off_replaced_and_added(satellite: Project) -> None:
    satellite.run("build-dynamics").ok()
    satellite.run("simulate", "3").ok()
    path = satellite.build / "simulation03.h5"
    thermal, stray, optical = (parts(path, group) for group in ("thermal", "stray", "optical"))
    (satellite.folder / "flat.csv").write_text("frequency_hz,amplitude\n1e-5,2e-15\n10,2e-15\n")
    configured(
        satellite,
        """
        [noise]
        omit = ["sun", "optical_TM1_eta"]
        [[noise.source]]
        name = "magnetic"
        table = "flat.csv"
        gains = { s_TM1_a_x = 1.0, s_TM2_a_x = -1.0 }
        [[noise.thruster]]
        position_m = [1.0, 0.0, 0.0]
        direction = [0.0, 0.0, 2.0]
        level = 1e-7
        """,
    )
    satellite.run("simulate", "3").ok()
    (groups,) = held(path, "group/name")
    name, gain, com = held(satellite.build / "dynamics.h5", "noise/name", "noise/gain", "spacecraft/centre_of_mass")
    assert "sun" not in groups
    assert "optical_TM1_eta" not in name
    np.testing.assert_array_equal(parts(path, "thermal"), thermal)
    np.testing.assert_array_equal(parts(path, "stray"), stray)
    assert (parts(path, "optical") <= optical).all()
    magnetic = parts(path, "magnetic")[OUTPUTS.index("delta_g_true")]
    np.testing.assert_allclose(magnetic, (2.0 * 2e-15) ** 2, rtol=1e-12)
    assert [n for n in name if n.startswith("thruster")] == ["thruster_1"]
    wrench = gain[:6, list(name).index("thruster_1")]
    np.testing.assert_allclose(wrench, [0, 0, 1, -com[1], com[0] - 1.0, 0], atol=1e-15)
    configured(satellite, '[noise]\npreset = "none"\n')
    satellite.run("simulate", "3").ok()
    assert list(held(path, "group/name")[0]) == ["thermal"]
    np.testing.assert_allclose(np.stack(list(psds(path).values())), thermal, rtol=1e-12)
