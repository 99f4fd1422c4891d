"""The audit of a mesh whose areas are of two units: sensitivities per kelvin are of mean temperatures alone."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from strut_model import LOWER, UPPER, deck, define, project

from tedm_cli.cli.printing.audit import audit_lines
from tedm_cli.config.project import load_project
from tedm_cli.contracts import SENSITIVITY
from tedm_cli.files.store import open_checked
from tedm_cli.progress import silent
from tedm_cli.stages.gravity.audit import audit
from tedm_cli.stages.gravity.sensitivity import build_sensitivity
from tedm_cli.stages.model.deck import write_deck
from tedm_cli.stages.model.distortion import build_distortion
from tedm_cli.stages.model.ingest import ingest
from tedm_cli.stages.model.solve import solve

TEST_MASS = '[[test_mass]]\nname = "TM1"\nposition_m = [0.05, 0.02, 0.25]\nside_m = 0.046\nmass_kg = 1.96\n'


def test_sensitivities_are_norms_over_mean_temperatures(tmp_path: Path) -> None:
    bent = define("BENT", kind='"gradient"', property=1)
    project(tmp_path, deck(1), bent + define("STRUTS", property=2, carrier='"elements"') + LOWER + UPPER)
    model = tmp_path / "model.toml"
    model.write_text(model.read_text(encoding="utf-8") + TEST_MASS, encoding="utf-8")
    here = load_project(tmp_path / "tedm.toml", tmp_path / "build")
    write_deck(here, None)
    solve(here, None, silent)
    ingest(here, None, silent)
    build_distortion(here, None, silent)
    build_sensitivity(here, None, silent)
    with open_checked(here.build_dir / "sensitivity.h5", SENSITIVITY) as file:
        S, kinds, rows = file.array("/S"), np.array(file.strings("/area/kind")), file.strings("/row/label")
    assert kinds.tolist().count("gradient") == 1
    done = audit(here, None, None, silent)
    found = dict(zip(done.audit.label, zip(done.audit.value, done.audit.unit, strict=True), strict=True))
    means = np.linalg.norm(S[:, kinds == "mean"], axis=1)
    assert (np.linalg.norm(S, axis=1) / means).max() > 1.0 + 1e-3  # the gradient has a part of its own
    for label, mean in zip(rows, means, strict=True):
        value, unit = found[label.replace("TM1_", "TM1_S_")]
        assert value == pytest.approx(mean, rel=1e-4)
        assert unit.endswith("/s^2/K")
    assert "S: norm over the areas of a mean temperature" in audit_lines(done, 3)
