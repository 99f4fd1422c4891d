"""What the report says of frames: the axes of turned test masses, and benches that move by themselves."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tedm_cli.config.project import Project
from tedm_cli.contracts import OPTICS, SENSITIVITY
from tedm_cli.files.store import open_checked
from tedm_cli.report.decision import cards_section
from tedm_cli.report.document import Block, Figure, Paragraph, Table
from tedm_cli.report.field import field_section
from tedm_cli.report.frames import own_axes
from tedm_cli.report.optics import optics_section
from tedm_cli.report.proof import binding_section
from tedm_cli.results.areas import read_areas
from tedm_cli.results.build_folder import open_results
from tedm_cli.results.cases.file import read_case
from tedm_cli.results.gravity.field import FieldAtRest, read_field
from tedm_cli.results.optics import read_optics
from tedm_cli.stages.reporting.plot_optics import optics_specs
from tedm_cli.stages.reporting.report import report

TURNED = Rotation.from_rotvec(np.radians(30.0) * np.array([0.0, 0.0, 1.0])).as_matrix().T
BOTH = np.array([np.eye(3), TURNED])


@pytest.fixture(scope="module")
def field(finished: Project) -> FieldAtRest:
    with open_checked(finished.build_dir / "sensitivity.h5", SENSITIVITY) as file:
        return read_field(file)


def tables(blocks: tuple[Block, ...], beginning: str) -> list[list[list[str]]]:
    """Texts of the tables whose captions begin so, row by row."""
    found = [b for b in blocks if isinstance(b, Table) and b.caption.startswith(beginning)]
    return [[[str(cell.text) for cell in row.cells] for row in table.rows] for table in found]


def test_axes_of_turned_test_masses_are_listed(field: FieldAtRest) -> None:
    np.testing.assert_allclose(field.axes, BOTH[[0, 0]], atol=1e-12)
    assert tables(field_section(field, []).blocks, "Axes") == []
    shown = tables(field_section(replace(field, axes=BOTH), []).blocks, "Axes x, y, z of each test mass")
    assert shown == [
        [
            ["TM1", "(1.000000, 0, 0)", "(0, 1.000000, 0)", "(0, 0, 1.000000)"],
            ["TM2", "(0.866025, 0.500000, 0)", "(−0.500000, 0.866025, 0)", "(0, 0, 1.000000)"],
        ]
    ]
    assert own_axes(["TM1"], np.array([np.eye(3)]), "") == []


def test_accelerations_at_rest_are_along_the_axes_of_their_test_mass(written: str) -> None:
    rows = [line for line in written.splitlines() if "Acceleration at rest of" in line]
    assert len(rows) == 2
    assert all("m/s² along x, y, z, the axes of the test mass" in line for line in rows)


@pytest.fixture(scope="module")
def written(finished: Project, tmp_path_factory: pytest.TempPathFactory) -> str:
    path = tmp_path_factory.mktemp("frames") / "report.md"
    return next(p for p in report(finished, path) if p.name == "report.md").read_text(encoding="utf-8")


def test_several_benches_are_listed_with_their_elements_and_axes_that_read_outs_are_along(finished: Project) -> None:
    with open_checked(finished.build_dir / "optics.h5", OPTICS) as file:
        optics, areas = read_optics(file), read_areas(file)
    figures: dict[str, list[Figure]] = defaultdict(list)
    assert optics.read_outs.benches == {"bench": [e for e in optics.read_outs.element if not e.startswith("TM")]}
    assert tables(optics_section(optics.quality, optics.read_outs, areas, figures).blocks, "Optical benches") == []
    assert tables(optics_section(optics.quality, optics.read_outs, areas, figures).blocks, "Axes") == []
    two = replace(optics.read_outs, benches={"OB1": ["FIT1", "M1"], "OB2": ["M2"]})
    shown = tables(optics_section(optics.quality, two, areas, figures).blocks, "Optical benches")
    turned = replace(optics.read_outs, axes=dict(zip(("TM1", "TM2"), BOTH, strict=True)))
    listed = tables(optics_section(optics.quality, turned, areas, figures).blocks, "Axes x, y, z of each test mass")
    assert listed[0][1] == ["TM2", "(0.866025, 0.500000, 0)", "(−0.500000, 0.866025, 0)", "(0, 0, 1.000000)"]
    assert shown == [[["OB1", "FIT1, M1"], ["OB2", "M2"]]]


@pytest.mark.parametrize(("benches", "said"), [(1, "if the bench did not"), (2, "if each bench did not")])
def test_of_several_benches_each_moves_as_one(finished: Project, benches: int, said: str) -> None:
    with open_results(finished) as results:
        cases = [read_case(r) for r in results.cases]
    section = binding_section(cases, benches, [])
    text = " ".join(cell for row in tables(section.blocks, "What the noise")[0] for cell in row)
    assert text.count(f"{said} move as one, the ratio would be") == 2
    cards = cards_section(cases, [], Paragraph(""), lambda name: name, benches)
    assert f"{said} move as one" in str(cards)


@pytest.mark.parametrize(("names", "said"), [(("OB", "OB"), "bench to"), (("OB1", "OB2"), "benches OB1 and OB2 to")])
def test_the_caption_of_the_benches_names_them(finished: Project, names: tuple[str, str], said: str) -> None:
    with open_results(finished) as results:
        read_out = results.read_out
        assert read_out is not None
        on = [
            e if e.kind == "test_mass" else replace(e, bench=names[e.name[-1] == "2"]) for e in read_out.layout.elements
        ]
        layout = replace(read_out.layout, elements=tuple(on))
        specs = optics_specs(replace(results, read_out=replace(read_out, layout=layout)))
    caption = {s.name: s.caption for s in specs}["bench.svg"]
    assert caption.startswith(f"The optical {said} scale, layout frame.")
