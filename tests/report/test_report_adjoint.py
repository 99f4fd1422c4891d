"""What the annex says of a model that has no adjoint here, and of an adjoint of other matrices."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from tedm_cli.config.project import Project
from tedm_cli.contracts import ADJOINT, SENSITIVITY
from tedm_cli.errors import InputError
from tedm_cli.files.build_folder import provenance
from tedm_cli.files.store import create, open_checked
from tedm_cli.results.adjoint.file import AdjointResults, read_adjoint
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


def found_by(project: Project) -> AdjointResults:
    """An adjoint.h5 that was found, of made-up numbers, by half of the project's accelerations; what it says."""
    build, rng = project.build_dir, np.random.default_rng(4)
    trace = provenance([], [build / "sensitivity.h5", build / "optics.h5"])
    sizes = {"row": 6, "area": 5, "node": 4, "element": 3, "material": 3, "shell": 2, "mapped": 3} | ADJOINT.fixed_dims
    with (
        open_checked(build / "sensitivity.h5", SENSITIVITY) as gravity,
        create(build / "adjoint.h5", ADJOINT, trace) as writer,
    ):
        # of rotations, which are not judged: there is no map to draw
        labels, units = gravity.strings(SENSITIVITY.ROW_LABEL)[6:], gravity.strings(SENSITIVITY.ROW_UNIT)[6:]
        copy_areas(gravity, writer)
        given = {
            ADJOINT.ROW_LABEL: labels,
            ADJOINT.ROW_UNIT: units,
            ADJOINT.CHECK_BLOCK: units,
            ADJOINT.MATERIAL_CARD: ["MAT1", "MAT1", "MAT9"],
            ADJOINT.MATERIAL_USED_BY: ["PSHELL 1, PSHELL 2", "PBAR 3, CONROD", "PSOLID 4"],
        }
        for path, spec in ADJOINT.datasets.items():
            if spec.group == ADJOINT.S.group and path not in given:
                shape = tuple(sizes[d] for d in spec.dims)
                whole = np.zeros(shape, dtype=int) if spec.values.flag else np.arange(1, 1 + int(np.prod(shape)))
                value = whole if spec.dtype == "int" else rng.uniform(0.5, 1.0, shape)
                writer.write(path, value, units=None if spec.units else "made up")
        for path, words in given.items():
            writer.write(path, words)
    with open_checked(build / "adjoint.h5", ADJOINT) as file:
        found = read_adjoint(file)
    assert not isinstance(found, str)
    return found


def test_the_annex_ranks_the_materials(copy: Project) -> None:
    """In the order and with the numbers of `tedm show`, whose meaning is tested with the command."""
    found = found_by(copy)
    decision, annex = (path.read_text(encoding="utf-8") for path in report(copy, None, ["md"]))
    lines = [
        line.strip("|").split("|") for line in annex.splitlines() if re.match(r"\| (expan|modul|dens|thick)", line)
    ]
    cells = [[cell.strip() for cell in line] for line in lines]
    assert len(cells) == len(found.materials) == 3 * 3 + 2
    for shown, effect in zip(cells, found.materials, strict=True):
        assert shown[:3] == [effect.quantity, effect.of, effect.used_by]
        assert float(shown[3].replace("−", "-")) == pytest.approx(effect.change, abs=6e-4)
        assert effect.output in shown[4].replace("\\", "")
        assert shown[5].replace("\\", "") == effect.area
    assert "Materials and shells" not in decision
    refused(copy, copy.build_dir / "sensitivity.h5")
    annex = report(copy, None, ["md"])[1].read_text(encoding="utf-8")
    assert "Materials and shells" not in annex


def test_an_adjoint_of_other_sensitivities_is_refused(copy: Project, tmp_path: Path) -> None:
    other = tmp_path / "sensitivity.h5"
    other.write_bytes(b"others")
    refused(copy, other)
    with pytest.raises(InputError, match="stale") as error:
        report(copy, None, ["md"])
    assert error.value.where.endswith("adjoint.h5")
    assert "tedm build-adjoint" in error.value.hint
