"""What the annex says of a model that has no adjoint here, and of an adjoint of other matrices."""

from __future__ import annotations

from pathlib import Path

import pytest

from tedm_cli.config.project import Project
from tedm_cli.contracts import ADJOINT, SENSITIVITY
from tedm_cli.errors import InputError
from tedm_cli.files.build_folder import provenance
from tedm_cli.files.store import create, open_checked
from tedm_cli.stages.common import copy_areas
from tedm_cli.stages.reporting.report import report

WHY = "the adjoint has no thermal coupling of: CELAS2 77001, 77002"


def refused(project: Project, sensitivity: Path) -> None:
    """adjoint.h5 as build-adjoint --or-say-why leaves it, of these sensitivities."""
    build = project.build_dir
    trace = provenance([], [sensitivity, build / "optics.h5"])
    with (
        open_checked(build / "sensitivity.h5", SENSITIVITY) as gravity,
        create(build / "adjoint.h5", ADJOINT, trace) as writer,
    ):
        copy_areas(gravity, writer)
        writer.write(ADJOINT.REFUSAL, [WHY])


def test_the_annex_says_why_there_is_no_adjoint(copy: Project) -> None:
    refused(copy, copy.build_dir / "sensitivity.h5")
    decision, annex = (path.read_text(encoding="utf-8") for path in report(copy, None, ["md"]))
    assert f"has not been found: {WHY}." in annex
    assert "adjoint.h5" in annex.partition("Provenance")[2]
    assert f"Where in the areas temperatures act has not been found: {WHY}." in decision
    assert "figures/adjoint_" not in decision + annex


def test_an_adjoint_of_other_sensitivities_is_refused(copy: Project, tmp_path: Path) -> None:
    other = tmp_path / "sensitivity.h5"
    other.write_bytes(b"others")
    refused(copy, other)
    with pytest.raises(InputError, match="stale") as error:
        report(copy, None, ["md"])
    assert error.value.where.endswith("adjoint.h5")
    assert "tedm build-adjoint" in error.value.hint
