"""A caption speaks of what its figure draws, and of nothing that is not there."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure
from report_project import CASES, field_at_rest, make_project

from tedm_cli.figures.drawing.spec import FigureSpec
from tedm_cli.progress import silent
from tedm_cli.results.build_folder import open_results
from tedm_cli.results.cases.file import read_case
from tedm_cli.stages.noise.series import run_series
from tedm_cli.stages.reporting.plot import figure_specs

SERIES = '\n[[series]]\nname = "warm"\nfile = "warm.csv"\nremove = "mean"\nlowest_hz = 1e-3\n'
VARIANTS = {
    "as it is": CASES,
    "no low-pass": CASES.replace('preset = "thesis"', 'preset = "white"'),
    "all met": CASES.replace('preset = "thesis"', 'preset = "thesis"\noutside_K = 1e-9\ninside_K = 1e-9'),
    "areas of a group differ": CASES.replace(
        'preset = "thesis"',
        'preset = "thesis"\n'
        + "".join(
            f'[[temperature.override]]\nareas = ["{area}"]\npreset = "thesis"\nlevel_K = {level}\n'
            for area, level in (("STRUT_1", 1e-3), ("STRUT_2", 2e-3), ("IS1_OUTER", 3e-4))
        ),
    ),
}


def both_together() -> dict[str, Any]:
    """The field at rest without subsystems: one verdict on each quantity of each test mass."""
    field = field_at_rest(np.random.default_rng(1))
    rows = field["/dc_verdict/whole"] == 1
    return {
        name: [v for v, kept in zip(value, rows, strict=True) if kept] if isinstance(value, list) else value[rows]
        for name, value in field.items()
        if name.startswith("/dc_verdict/")
    }


def drawn(folder: Path, cases: str, changed: Mapping[str, Any] | None = None) -> dict[str, tuple[FigureSpec, Figure]]:
    """Figures that bear a caption with conditions, by the first word of their names."""
    folder.mkdir(exist_ok=True)
    rng = np.random.default_rng(5)
    table = np.column_stack([10.0 * np.arange(9000), 293.0 + 1e-5 * np.cumsum(rng.normal(size=(9000, 1)), axis=0)])
    np.savetxt(folder / "warm.csv", table, delimiter=",", header="time_s,all", comments="", fmt="%.12g")
    project = make_project(folder, cases + SERIES, changed)
    run_series(project, ["warm"], None, silent)
    with open_results(project) as results:
        specs = figure_specs(results, list(map(read_case, results.cases)))
        names = ("ratios", "certainty_acceleration", "cases_displacement", "cases_acceleration", "field_at_rest",
                 "series_warm", "improvement")  # fmt: skip
        return {s.name.removesuffix(".svg"): (s, s.draw()) for s in specs if s.name.startswith(names)}


def labels(figure: Figure) -> set[str]:
    """Labels of lines and of legends."""
    lines = {str(line.get_label()) for axes in figure.axes for line in axes.get_lines()}
    return lines | {text.get_text() for legend in figure.legends for text in legend.get_texts()}


def words(figure: Figure) -> str:
    return " ".join(t.get_text() for t in [*figure.texts, *(t for axes in figure.axes for t in axes.texts)])


@pytest.mark.parametrize("name", VARIANTS)
def test_captions_are_true_of_what_is_drawn(tmp_path: Path, name: str) -> None:
    found = drawn(tmp_path / "p", VARIANTS[name])
    spec, figure = found["ratios"]
    assert ("grey bars" in spec.caption) == ("range over filter orders and corners" in labels(figure))
    assert ("grey bars" in spec.caption) == (name != "no low-pass")
    spec, figure = found["certainty_acceleration"]
    assert ("temperature filters" in spec.caption) == ("the case with other filters" in labels(figure))
    violated = []
    for kind in ("acceleration", "displacement"):
        spec, figure = found[f"cases_{kind}"]
        hatched = any(c.get_hatch() for axes in figure.axes for c in axes.collections)
        assert ("Hatched" in spec.caption) == hatched
        violated.append(hatched)
    assert any(violated) == (name != "all met")
    spec, figure = found["field_at_rest"]
    assert "for parts of the model and all of it, TM2 − TM1 being the difference of the two" in spec.caption
    assert "IS: inertial sensor" in labels(figure)
    for key, (spec, figure) in found.items():
        if key.startswith("improvement"):
            beside = [t.get_text() for t in figure.axes[1].texts]
            levels = [text for text in beside if not text.startswith(("×", "cannot", "not felt"))]
            assert ("right: the amplitude" in spec.caption) == bool(levels)
            assert ("K/√Hz" in words(figure)) == bool(levels)
            assert ("times that factor" in spec.caption) == any("=" in text for text in levels)
    spec, figure = found["series_warm"]
    assert "that is worst" in spec.caption
    assert "not judged" not in words(figure)


def test_captions_of_a_field_without_subsystems_and_a_series_without_requirements(tmp_path: Path) -> None:
    found = drawn(tmp_path / "p", CASES[: CASES.index("[[requirement]]")] + CASES[CASES.index("[[case]]") :])
    assert set(found) == {"field_at_rest", "series_warm"}
    spec, figure = found["series_warm"]
    assert "of the largest rms" in spec.caption
    assert "not judged" in words(figure)
    spec, figure = drawn(tmp_path / "q", CASES, both_together())["field_at_rest"]
    assert "for everything in the model, TM2 − TM1" in spec.caption
    assert not [label for label in labels(figure) if label.startswith("IS: ")]
    assert "IS+LTP: both together" in labels(figure)
