"""The loop that is handed to other simulators is the one whose spectra are judged."""

from __future__ import annotations

import shutil
import sys
from dataclasses import replace
from pathlib import Path
from unittest import mock

import numpy as np
import pytest
import scipy.io
import scipy.linalg

from tedm_cli.cli import main
from tedm_cli.config.project import Project
from tedm_cli.contracts import DYNAMICS, OPTICS, SENSITIVITY
from tedm_cli.dynamics.closed_loop import responses
from tedm_cli.dynamics.signals import DISTURBANCES, OUTPUTS, unit
from tedm_cli.errors import InputError
from tedm_cli.files.store import open_checked
from tedm_cli.stages.dynamics.build import build_dynamics
from tedm_cli.stages.dynamics.loop import project_loop
from tedm_cli.stages.exports.closed_loop import export_closed_loop
from tedm_cli.stages.optics.build import build_optics

F = np.array([2e-4, 1e-3, 7e-3, 3e-2])


@pytest.fixture(scope="module")
def closed(small: Project, tmp_path_factory: pytest.TempPathFactory) -> Project:
    build = tmp_path_factory.mktemp("closed") / "build"
    shutil.copytree(small.build_dir, build)
    project = replace(small, build_dir=build)
    build_dynamics(project, None)
    return project


def test_state_space_of_the_loop_has_the_transfer_functions_of_the_loop(closed: Project) -> None:
    done = export_closed_loop(closed.build_dir, "mat", None)
    m = scipy.io.loadmat(done.paths[0], simplify_cells=True)
    a, b, c, d = (m[name]["value"] for name in "ABCD")
    inputs, outputs = list(m["B"]["columns"]), list(m["C"]["rows"])
    assert outputs == list(OUTPUTS)
    assert inputs[: len(DISTURBANCES)] == list(DISTURBANCES)
    assert list(m["C"]["row_units"]) == [unit(name) for name in OUTPUTS]
    assert len(set(m["A"]["rows"])) == done.states == len(a)
    assert np.linalg.eigvals(a).real.max() < 0.0
    loop = project_loop(closed)
    exact = np.concatenate([h for _, h in responses(loop.plant, loop.controller, F)])
    for k, f in enumerate(F):
        s = 2j * np.pi * f
        whole = c @ np.linalg.solve(s * np.eye(len(a)) - a, b) + d
        got = whole[:, : len(DISTURBANCES)].copy()
        for name in ("TM1_x", "TM2_x"):
            got[:, inputs.index(f"n_{name}")] += s**2 * whole[:, inputs.index(f"nddot_{name}")]
        size = np.abs(exact[k]).max(axis=1, keepdims=True)
        size[size == 0.0] = 1.0
        np.testing.assert_allclose(got / size, exact[k] / size, atol=1e-9)


def test_temperatures_of_the_exported_loop_are_sensitivities_of_the_project(closed: Project) -> None:
    done = export_closed_loop(closed.build_dir, "npz", None)
    with np.load(done.paths[0]) as m:
        v, rows, areas = m["V"], list(m["V.rows"]), list(m["V.columns"])
    with (
        open_checked(closed.build_dir / "sensitivity.h5", SENSITIVITY) as s,
        open_checked(closed.build_dir / "optics.h5", OPTICS) as o,
    ):
        assert areas == s.strings(SENSITIVITY.AREA_NAME)
        gravity = dict(zip(s.strings(SENSITIVITY.ROW_LABEL), s.array(SENSITIVITY.S), strict=True))
        chosen = o.strings(OPTICS.SET_NAME)[0]
        read_out = dict(zip(o.strings(OPTICS.LABEL_READ_OUT), o.array(OPTICS.N.of(chosen)), strict=True))
    assert len(gravity) == 12
    for name, row in gravity.items():
        np.testing.assert_array_equal(v[rows.index(f"s_{name}")], row)
    for name, row in read_out.items():
        if f"n_{name}" in rows:
            np.testing.assert_array_equal(v[rows.index(f"n_{name}")], row)
    assert not v[: rows.index("n_SC_theta")].any()  # temperatures push no thruster


def _another(layout: Path, folder: Path) -> Path:
    """The same layout with another wavelength, beside the files that it names."""
    shutil.copytree(layout.parent, folder / "layout")
    changed = folder / "layout" / layout.name
    text = changed.read_text(encoding="utf-8")
    changed.write_text(text.replace("wavelength_m = 1.064e-6", "wavelength_m = 1.55e-6"), encoding="utf-8")
    return changed


def command(*arguments: str) -> int:
    with (
        mock.patch.object(sys, "argv", ["tedm", "export-state-space", *arguments]),
        pytest.raises(SystemExit) as ended,
    ):
        main()
    return int(ended.value.code or 0)


def test_the_command_writes_the_loop_and_refuses_a_stale_one(
    closed: Project, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    build = tmp_path / "build"
    shutil.copytree(closed.build_dir, build)
    target = tmp_path / "loop.npz"
    assert command("--loop", "-d", str(build), "-o", str(target), "--format", "npz") == 0
    assert "47 inputs, 75 outputs" in capsys.readouterr().out
    assert target.exists()
    assert command("-d", str(build)) == 2
    assert "--loop" in capsys.readouterr().err
    build_optics(replace(closed, build_dir=build, optics=_another(closed.required_optics(), tmp_path)), None)
    with pytest.raises(InputError, match="stale"):
        export_closed_loop(build, "npz", None)
    (build / "dynamics.h5").unlink()
    with pytest.raises(InputError, match="no such file"):
        export_closed_loop(build, "npz", None)


def test_a_sampled_controller_has_no_continuous_system(closed: Project, tmp_path: Path) -> None:
    build = tmp_path / "build"
    shutil.copytree(closed.build_dir, build)
    with open_checked(build / "dynamics.h5", DYNAMICS) as file:
        a, b, c, d = (file.array(getattr(DYNAMICS, f"CONTROLLER_{x}")) for x in "ABCD")
        names, commands = file.strings(DYNAMICS.LABEL_COORDINATE), file.strings(DYNAMICS.LABEL_INPUT)
    dt = 0.01
    n = len(a)
    step = scipy.linalg.expm(np.block([[a, b], [np.zeros((15, n + 15))]]) * dt)
    np.savez(
        tmp_path / "sampled.npz", A=step[:n, :n], B=step[:n, n:], C=c, D=d, inputs=names, outputs=commands, dt_s=dt
    )
    (tmp_path / "dynamics.toml").write_text('[controller]\nfile = "sampled.npz"\n')
    project = replace(closed, build_dir=build, dynamics=tmp_path / "dynamics.toml")
    build_dynamics(project, None)
    with pytest.raises(InputError, match="sampled controller has no continuous state space"):
        export_closed_loop(build, "npz", None)


def test_a_loop_of_another_configuration_is_refused(closed: Project, tmp_path: Path) -> None:
    moved = tmp_path / "model.toml"
    moved.write_text(closed.model.read_text(encoding="utf-8") + "# moved\n", encoding="utf-8")
    with pytest.raises(InputError, match="stale") as refused:
        build_dynamics(replace(closed, model=moved), tmp_path / "dynamics.h5")
    assert refused.value.hint == "rebuild it with `tedm build-sensitivity`, or `tedm run`"
