"""Numbers of the small sample that move only for a reason; they and their tolerances are in tests/regression.toml."""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
import pytest

from tedm_cli.config.project import Project
from tedm_cli.contracts import CASE, OPTICS, SENSITIVITY, UNIT_LOADS
from tedm_cli.files.store import open_checked

TABLE = tomllib.loads((Path(__file__).parents[1] / "regression.toml").read_text(encoding="utf-8"))


def numbers(project: Project) -> dict[str, float]:
    """All numbers that the regression file may name."""
    out: dict[str, float] = {}
    with open_checked(project.build_dir / "unit_loads.h5", UNIT_LOADS) as file:
        out["mass_kg"] = file.number("/mass/total")
    with open_checked(project.build_dir / "sensitivity.h5", SENSITIVITY) as file:
        field = file.array("/dc/acceleration")
        out |= {f"TM1_structure_a_{c}": field[0, 0, i] for i, c in enumerate("xyz")}
        out["TM1_other_a_x"] = field[0, 1, 0]
        out["TM1_structure_gamma_xx"] = file.array("/stiffness/gamma_lin")[0, 0, 0, 0]
        out["TM1_structure_omega_ang_yy"] = file.array("/stiffness/omega_ang")[0, 0, 1, 1]
        s = file.array("/S")
        out |= {f"norm_S_{label}": float(np.linalg.norm(s[i])) for i, label in enumerate(file.strings("/row/label"))}
    with open_checked(project.build_dir / "optics.h5", OPTICS) as file:
        out["condition_A"], out["condition_B"] = file.array("/set/condition")
        n = file.array("/N/A")
        out |= {
            f"norm_N_A_{label}": float(np.linalg.norm(n[i])) for i, label in enumerate(file.strings("/label/read_out"))
        }
    for path in sorted(project.build_dir.glob("case*.h5")):
        with open_checked(path, CASE) as file:
            for label, ratio in zip(file.strings("/verdict/output"), file.array("/verdict/ratio"), strict=True):
                out[f"{path.stem}_{label}"] = ratio
    return out


@pytest.fixture(scope="module")
def found(small: Project) -> dict[str, float]:
    return numbers(small)


@pytest.mark.parametrize("name", sorted(TABLE["value"]))
def test_number(found: dict[str, float], name: str) -> None:
    tolerance = TABLE["tolerance"]
    rtol = tolerance["by_name"].get(name, tolerance["relative"])
    assert found[name] == pytest.approx(TABLE["value"][name], rel=rtol, abs=0.0)
