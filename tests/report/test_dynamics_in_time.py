"""The loop in time in figures and report: what they show is in the files, and stale series are refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from report_project import CASES, make_project, sketch

from tedm_cli.config.project import Project, load_project
from tedm_cli.contracts import SIMULATED_SERIES, SIMULATION
from tedm_cli.errors import InputError
from tedm_cli.figures.cases.series import series_figure
from tedm_cli.figures.drawing.style import style
from tedm_cli.figures.dynamics_in_time import realisation_figure
from tedm_cli.files.seal import sha256_of
from tedm_cli.files.store import open_checked
from tedm_cli.progress import silent
from tedm_cli.results.build_folder import open_results
from tedm_cli.results.dynamics.in_time import read_realised, read_simulated_series
from tedm_cli.results.wording import ratio_text
from tedm_cli.stages.dynamics.build import build_dynamics
from tedm_cli.stages.dynamics.series import simulate_series
from tedm_cli.stages.dynamics.simulate import simulate
from tedm_cli.stages.reporting.plot_dynamics_in_time import in_time_specs
from tedm_cli.stages.reporting.report import report

DYNAMICS = """
[noise]
omit = ["capacitive"]
[time]
samples = 32000
[[requirement]]
name = "lpf_acceleration"
outputs = ["delta_g"]
applies_to = "differential"
"""
SERIES = '\n[[series]]\nname = "warm"\nfile = "warm.csv"\nremove = "mean"\n'


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Project:
    """One case, realised in time, and one series through the loop."""
    folder = tmp_path_factory.mktemp("in_time")
    walk = 1e-5 * np.cumsum(np.random.default_rng(5).normal(size=(12_000, 1)), axis=0)
    table = np.column_stack([10.0 * np.arange(12_000), 293.0 + walk])
    np.savetxt(folder / "warm.csv", table, delimiter=",", header="time_s,all", comments="", fmt="%.12g")
    one = CASES[: CASES.index("[[case]]", CASES.index("[[case]]") + 1)]
    make_project(folder, one + SERIES)
    (folder / "dynamics.toml").write_text(DYNAMICS)
    (folder / "tedm.toml").write_text('title = "in time"\ndynamics = "dynamics.toml"\n')
    made = load_project(folder / "tedm.toml", folder / "build")
    build_dynamics(made, None)
    simulate(made, ["1"], None, silent, in_time=True)
    simulate_series(made, ["warm"], None, silent)
    return made


def test_a_figure_for_each_realisation_and_each_series(project: Project) -> None:
    with open_results(project) as results:
        specs = {s.name: s for s in in_time_specs(results)}
        assert list(specs) == ["closed_loop_realised_case01.svg", "simulation_warm.svg"]
        for spec in specs.values():
            figure = spec.draw()
            with style():
                box = figure.get_tightbbox()
            width, tall = figure.get_size_inches()
            assert (box.x0 >= 0, box.y0 >= 0, box.x1 <= width, box.y1 <= tall) == (True,) * 4, spec.name
    docs = (Path(__file__).parents[2] / "docs" / "reference" / "figures.md").read_text(encoding="utf-8")
    assert "`closed_loop_realised_caseNN.svg`" in docs
    assert "`simulation_NAME.svg`" in docs


def test_a_realisation_is_drawn_over_its_expectation(project: Project) -> None:
    with open_checked(project.build_dir / "simulation01.h5", SIMULATION) as file:
        found = read_realised(file)
        ratio = file.array("/realisation/psd")[0] / file.array("/realisation/exact")[0]
    assert found is not None
    assert found.mean["delta_g"] == pytest.approx(ratio.mean())
    axes = realisation_figure(found).axes[0]
    line = np.asarray(axes.get_lines()[0].get_ydata())
    assert (line.min(), line.max()) == pytest.approx((np.sqrt(ratio.min()), np.sqrt(ratio.max())), rel=1e-12)
    assert np.asarray(axes.get_lines()[1].get_ydata()).tolist() == [1.0, 1.0]
    assert 0.8 < found.held <= 1.0


def test_a_series_is_drawn_with_its_parts(project: Project) -> None:
    with open_results(project) as results:
        file = results.simulated_series["warm"]
        noise = read_simulated_series(file, results.loop_requirements, 0.95)
        parts = [file.array(p.of("delta_g")) for p in (SIMULATED_SERIES.GRAVITY_PSD, SIMULATED_SERIES.READ_OUT_PSD)]
    (output,) = noise.outputs
    assert output.output == "delta_g"
    drawn = series_figure(noise).axes[1].get_lines()
    for line, psd in zip(drawn[2:4], parts, strict=True):
        assert np.asarray(line.get_ydata()).max() == pytest.approx(2.0 * np.sqrt(psd.max()), rel=1e-12, abs=0)


def test_the_report_tells_of_both(project: Project) -> None:
    sketch(project)
    annex = project.build_dir / "r_annex.md"
    assert annex in report(project, project.build_dir / "r.md")
    text = annex.read_text(encoding="utf-8")
    section = text[text.index("## Closed loop") :]
    section = section[: section.index("\n## ", 5)]
    assert "### Realised in time" in section
    assert "| Differential acceleration Δg (as LISA Pathfinder computes it) (delta_g) | 1 | " in section
    assert "### Series warm through the loop" in section
    with open_checked(project.build_dir / "simulation_warm.h5", SIMULATED_SERIES) as file:
        (ratio,) = file.array("/verdict/ratio")
    assert ratio_text(float(ratio)) in section
    assert sha256_of(project.build_dir / "simulation_warm.h5") in text


def test_a_series_of_another_loop_is_refused(project: Project) -> None:
    text = (project.build_dir.parent / "dynamics.toml").read_text(encoding="utf-8")
    kept = {p: p.read_bytes() for p in project.build_dir.glob("*.h5")}
    try:
        (project.build_dir.parent / "dynamics.toml").write_text(text + "# another\n", encoding="utf-8")
        build_dynamics(project, None)
        simulate(project, ["1"], None, silent)
        with pytest.raises(InputError) as caught, open_results(project):
            pass
        assert caught.value.where.endswith("simulation_warm.h5")
        assert "tedm simulate --series warm" in caught.value.hint
    finally:
        (project.build_dir.parent / "dynamics.toml").write_text(text, encoding="utf-8")
        for path, data in kept.items():
            path.write_bytes(data)
