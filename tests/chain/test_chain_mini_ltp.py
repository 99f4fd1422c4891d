"""The chain on a model solved by an independent solver, against its reference results, to the accuracy of the OP2."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tedm_cli.config.project import Project
from tedm_cli.contracts import DISTORTION, SENSITIVITY, UNIT_LOADS
from tedm_cli.errors import InputError
from tedm_cli.files.store import open_checked
from tedm_cli.nastran.op2.reader import open_op2

# The OP2 holds single precision; the reference was computed from the same file, so double precision must be met
# wherever the arithmetic is the same.
DOUBLE = 1e-12


@pytest.fixture(scope="module")
def reference(mini_ltp_dir: Path) -> dict[str, Any]:
    data: dict[str, Any] = json.loads((mini_ltp_dir / "reference.json").read_text())
    data["arrays"] = np.load(mini_ltp_dir / "reference.npz")
    return data


def relative(found: np.ndarray, wanted: np.ndarray) -> float:
    return float(np.abs(found - wanted).max() / np.abs(wanted).max())


def test_lumped_masses_and_total(mini: Project, reference: dict[str, Any]) -> None:
    with open_checked(mini.build_dir / "unit_loads.h5", UNIT_LOADS) as file:
        assert relative(file.array("/mass/lumped"), reference["arrays"]["mass"]) < DOUBLE
        assert file.number("/mass/total") == pytest.approx(reference["mass"]["total"], rel=DOUBLE)
        # The solver's own grid point weight generator, to the digits it prints.
        assert file.number("/mass/total") == pytest.approx(reference["mass"]["mystran_grdpnt"], abs=5e-6)
        np.testing.assert_allclose(
            file.array("/mass/centre_of_gravity"), reference["mass"]["cg_lumped"], rtol=0, atol=1e-14
        )


def test_distortion_matrix(mini: Project, reference: dict[str, Any]) -> None:
    with open_checked(mini.build_dir / "distortion.h5", DISTORTION) as file:
        order = [reference["S_columns"].index(name) for name in file.strings("/area/name")]
        wanted = reference["arrays"]["D"][order]
        assert relative(file.array("/D/translation"), wanted[:, :, :3]) < DOUBLE
        rows = np.searchsorted(file.array("/grid/id"), file.array("/optical/grid"))
        assert relative(file.array("/D_opt/rotation"), wanted[:, rows, 3:]) < DOUBLE
        assert file.number("/check/superposition_translation") < 2e-7


def test_sensitivity_matrix(mini: Project, reference: dict[str, Any]) -> None:
    with open_checked(mini.build_dir / "sensitivity.h5", SENSITIVITY) as file:
        order = [reference["S_columns"].index(name) for name in file.strings("/area/name")]
        wanted = np.array(reference["S_SG"])[:, order]
        found = file.array("/S")
    for block in range(4):  # a1, a2, omegadot1, omegadot2: each against its own size
        rows = slice(3 * block, 3 * block + 3)
        assert relative(found[rows], wanted[rows]) < 1e-10


def test_field_at_rest_and_stiffness(mini: Project, reference: dict[str, Any]) -> None:
    with open_checked(mini.build_dir / "sensitivity.h5", SENSITIVITY) as file:
        for t, tm in enumerate(reference["tm"]):
            assert relative(file.array("/dc/acceleration")[t, 0], np.array(tm["a_dc"])) < DOUBLE
            assert relative(file.array("/dc/angular_acceleration")[t, 0], np.array(tm["omegadot_dc"])) < 1e-10
            gamma, omega = np.array(tm["Gamma_lin"]) / tm["mass"], np.array(tm["Omega_lin"]) / tm["inertia"]
            assert relative(file.array("/stiffness/gamma_lin")[t, 0], gamma) < DOUBLE
            assert relative(file.array("/stiffness/omega_lin")[t, 0], omega) < 1e-10


def test_overlapping_areas_are_refused(make_mini: Callable[[str], Project]) -> None:
    """The split deck warms two areas whole and in parts: no partition."""
    with pytest.raises(InputError, match="more than one thermal area"):
        make_mini("mini_ltp_split")


def test_split_areas_sum_to_the_whole(mini_ltp_dir: Path) -> None:
    """Superposition in the independent solver's results: an area's motion is the sum of its parts' motions."""
    with open_op2(mini_ltp_dir / "mini_ltp_split.op2") as (tables, read):
        motion = {table.subcase: read(table).motion for table in tables}
    for whole, parts in ((1, (2, 3)), (4, (5, 6))):
        assert relative(np.sum([motion[p] for p in parts], axis=0), motion[whole]) < 2e-7
