"""The audit of a mesh: its errors are the differences of the fields, and its worst elements are the near ones."""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tedm_cli.cli.printing.as_json import json_text
from tedm_cli.cli.printing.audit import audit_lines, conclusion
from tedm_cli.config.model.file import load_model
from tedm_cli.config.project import Project, load_project
from tedm_cli.contracts import SENSITIVITY, UNIT_LOADS
from tedm_cli.files.store import open_checked
from tedm_cli.gravity.audit import MODELS
from tedm_cli.gravity.structure import structure_gravity
from tedm_cli.progress import silent
from tedm_cli.results.unit_loads import mass_of
from tedm_cli.stages.gravity.audit import AuditSummary, audit
from tedm_cli.stages.model.ingest import ingest


@pytest.fixture(scope="module")
def csv_path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("audit") / "mesh.csv"


@pytest.fixture(scope="module")
def done(small: Project, csv_path: Path) -> AuditSummary:
    counts = []
    summary = audit(small, csv_path, csv_path.with_suffix(".svg"), lambda done, total, _: counts.append((done, total)))
    assert counts[-1][0] == counts[-1][1]  # progress ends where it said it would
    return summary


def row(done: AuditSummary, label: str) -> int:
    return done.audit.label.index(label)


def test_error_of_the_sum_is_the_difference_of_the_fields(small: Project, done: AuditSummary) -> None:
    a = done.audit
    with open_checked(small.build_dir / "unit_loads.h5", UNIT_LOADS) as unit:
        tm = load_model(small.model)[1].test_masses()[1]
        lumped = structure_gravity(mass_of(unit, lumped=True), tm, tolerance=done.tolerance).field
        fine = structure_gravity(mass_of(unit), tm, tolerance=1e-2 * done.tolerance).field
    for label, one, two in (
        ("TM2_a_x", lumped.acceleration[0], fine.acceleration[0]),
        ("TM2_omegadot_y", lumped.angular_acceleration[1], fine.angular_acceleration[1]),
        ("TM2_gamma_xz", lumped.gamma_lin[0, 2], fine.gamma_lin[0, 2]),
    ):
        q = row(done, label)
        assert a.value[q] == pytest.approx(two, rel=1e-9)
        assert a.total[0, q] == pytest.approx(one - two, rel=1e-9)
        assert a.error[0, q].sum() == pytest.approx(one - two, rel=1e-9)


def test_quadrature_in_use_keeps_its_tolerance_and_the_requirement(small: Project, done: AuditSummary) -> None:
    """Summed without regard to sign the elements' errors stay below 1 % of the allowance of 1 %."""
    a = done.audit
    linear = np.abs(a.error[1]).sum(axis=1)
    assert (linear < 0.01 * np.maximum(a.allowance, 1e-30))[~np.isnan(a.requirement)].all()
    with open_checked(small.build_dir / "sensitivity.h5", SENSITIVITY) as file:
        norms = dict(zip(file.strings("/row/label"), np.linalg.norm(file.array("/S"), axis=1), strict=True))
    for tm in ("TM1", "TM2"):
        for kind in ("a", "omegadot"):
            q = row(done, f"{tm}_S_{kind}_x")
            assert a.value[q] == pytest.approx(norms[f"{tm}_{kind}_x"], rel=1e-4)


def test_errors_are_held_against_configured_limits(small: Project, done: AuditSummary, tmp_path: Path) -> None:
    """Limits of LISA Pathfinder; limits of another mission; and none, where the largest of a kind has to do."""
    found = dict(zip(done.audit.label, done.audit.requirement, strict=True))
    assert [found[f"TM1_{q}"] for q in ("a_x", "a_z", "omegadot_x", "gamma_xx", "gamma_yz")] == pytest.approx(
        [0.75e-9, 2.2e-9, 16e-9, 3e-7, 3e-7]
    )
    text = small.model.read_text(encoding="utf-8")
    (tmp_path / "unit_loads.h5").write_bytes((small.build_dir / "unit_loads.h5").read_bytes())
    own = '[[requirement_at_rest]]\nname = "own"\nquantity = "a_y"\nmagnitude = 5e-9\ntest_mass = "TM2"\n'
    (tmp_path / "model.toml").write_text(text.replace('[[requirement_at_rest]]\nname = "lpf"\n', own), encoding="utf-8")
    other = replace(small, model=tmp_path / "model.toml", build_dir=tmp_path)
    a = audit(other, None, None, silent).audit
    row = {label: i for i, label in enumerate(a.label)}
    assert a.allowance[row["TM2_a_y"]] == pytest.approx(5e-11)
    assert np.isnan(a.requirement[row["TM1_a_y"]])
    largest = max(abs(a.value[row[f"TM1_a_{axis}"]]) for axis in "xyz")
    assert a.allowance[row["TM1_a_y"]] == pytest.approx(0.01 * largest)
    assert abs(a.value[row["TM1_a_y"]]) < 0.5 * largest
    assert a.allowance[row["TM1_S_a_x"]] == pytest.approx(0.01 * abs(a.value[row["TM1_S_a_x"]]))


def test_worst_elements_are_close_to_a_test_mass(done: AuditSummary) -> None:
    """Elements of 66 mm at 4 mm come first, and the mirrored model has them in pairs."""
    a = done.audit
    worst = done.worst(8)
    assert (a.gap[:, worst].min(axis=0) < 0.03).all()
    assert (a.size[worst] > 0.02).all()
    assert a.score[0, worst[0]] == pytest.approx(a.score[0, worst[1]], rel=1e-3)
    assert a.score[1].max() < 1e-3 * a.score[0].max()


def test_without_displacements_the_bound_holds(small: Project, tmp_path: Path) -> None:
    """Every grid moved by a metre the worst way: more than any motion of that size makes."""
    project = load_project(small.file.path, tmp_path)
    ingest(project, None, silent)
    bound = audit(project, None, None, silent)
    assert not bound.per_kelvin
    q = row(bound, "TM1_S_a_x")
    with open_checked(small.build_dir / "sensitivity.h5", SENSITIVITY) as file:
        g = file.array("/operator/G")[file.strings("/row/label").index("TM1_a_x")]
    assert np.linalg.norm(g, axis=1).sum() <= bound.audit.value[q] * (1 + 1e-6)


def test_table_names_the_worst_and_the_csv_has_every_element(done: AuditSummary, csv_path: Path) -> None:
    lines = audit_lines(done, 3)
    first = str(done.audit.element_id[done.worst(1)[0]])
    assert any(line.split()[:2] == [first, "CHEXA"] for line in lines)
    assert json.loads(json_text(done.as_dict(3)))["elements"][0]["element"] == int(first)
    rows = list(csv.DictReader(csv_path.open(encoding="utf-8")))
    scores = [float(r[f"score_{MODELS[0]}"]) for r in rows]
    assert scores == sorted(scores, reverse=True)
    assert rows[0]["element"] == first
    assert sorted(int(r["element"]) for r in rows) == sorted(done.audit.element_id)


def test_figure_has_units_and_says_how_many_exceed(done: AuditSummary, csv_path: Path) -> None:
    text = csv_path.with_suffix(".svg").read_text(encoding="utf-8")
    for label in ("gap to the nearest test mass (mm)", "size of the element (mm)", "error over 1 % of the requirement"):
        assert label in text
    assert f"{int((done.audit.score[0] > 1.0).sum()):,} of {len(done.audit.element_id):,} elements exceed" in text


def test_the_verdict_comes_first_and_the_conclusion_last(done: AuditSummary) -> None:
    """Quadrature keeps the requirement, lumped masses do not: what remains, whether it is allowed, what to do."""
    lines = audit_lines(done, 1)
    label, ratio = done.largest("quadrature")
    a = done.audit
    assert ratio == pytest.approx(np.max(np.abs(a.total[1]) / a.allowance))
    assert lines[0].startswith("pass: quadrature over the elements (in use)")
    assert lines[1].startswith("FAIL: lumped masses (not in use)")
    assert f"in {label}, is {ratio:.3g} of what is allowed: the mesh is fine enough" in lines[-1]
    assert done.passed
    lumped = replace(done, mass_model="lumped")
    assert not lumped.passed
    assert audit_lines(lumped, 1)[0].startswith("FAIL: lumped masses (in use)")
    assert 'set mass_model = "quadrature" in [gravity]' in conclusion(lumped)
    coarse = replace(done, audit=replace(a, total=1e9 * a.total))
    assert "lower quadrature_tolerance, now 0.0001" in conclusion(coarse)


def test_rounding_is_printed_as_nought(done: AuditSummary) -> None:
    """What is left by rounding of a field that is zero by symmetry is no number to read."""
    a, q = done.audit, row(done, "TM1_a_y")
    value, total = a.value.copy(), a.total.copy()
    value[q], total[:, q] = 2e-24, (-1e-24, 3e-24)
    lines = audit_lines(replace(done, audit=replace(a, value=value, total=total)), 1)
    cells = {line.split()[0]: line.split() for line in lines if line.startswith("TM1_a_")}
    assert [cells["TM1_a_y"][i] for i in (2, 4, 7, 9, 10)] == ["0"] * 5
    assert cells["TM1_a_x"][2] == f"{a.value[row(done, 'TM1_a_x')]:.3e}"
