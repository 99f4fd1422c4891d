"""Figure 6.2 among the figures: its curves are those of the file, and a stale file is refused."""

from __future__ import annotations

import h5py
import numpy as np
import pytest
from matplotlib.lines import Line2D

from tedm_cli.config.project import Project
from tedm_cli.errors import InputError
from tedm_cli.files.seal import seal
from tedm_cli.results.build_folder import open_results
from tedm_cli.results.dynamics.imposed import read_imposed
from tedm_cli.stages.dynamics.imposed import imposed_motion
from tedm_cli.stages.reporting.plot_imposed import imposed_specs
from tedm_cli.stages.reporting.show import show_dict


def height(line: Line2D) -> np.ndarray:
    return np.asarray(line.get_ydata(), dtype=float)


def test_the_figure_is_drawn_where_it_was_made(copy: Project) -> None:
    with open_results(copy) as results:
        assert imposed_specs(results) == []
    path, found = imposed_motion(copy, None)
    with open_results(copy) as results:
        (spec,) = imposed_specs(results)
        assert results.imposed is not None
        assert read_imposed(results.imposed).noises[0].ratio == found.noises[0].ratio
    assert spec.name == "figure_6_2.svg"
    assert "5 nm/√Hz" in spec.caption
    figure = spec.draw()
    spectra, parts = figure.axes
    named = [text.get_text().replace("\n", " ") for text in figure.legends[0].get_texts()]
    assert len(named) == len(found.noises) + 2
    lines = dict(zip(named, spectra.get_lines(), strict=False))  # beyond the key: ends of the band
    for n in found.noises:
        np.testing.assert_array_equal(height(lines[f"{n.test_mass}, {n.model}"]), n.asd)
    np.testing.assert_allclose(height(lines["TM1, Montemurro 2004: other test mass"]), 3.4348e-17, rtol=1.5e-5)
    np.testing.assert_array_equal(
        height(lines["requirement: LISA Pathfinder, self-gravity noise of the LTP"]), found.limit.amplitude
    )
    names = [label.get_text() for label in parts.get_yticklabels()]
    for n, line in zip(found.noises, parts.get_lines(), strict=False):
        at = {names[round(y)].replace("\n", " "): x for x, y in zip(line.get_xdata(), height(line), strict=True)}
        assert at == {source: asd[0] for source, asd in n.alone.items()}
    assert show_dict(path)["main"]["TM1, Montemurro 2004"].startswith("1.1047e-16")


def test_a_figure_of_other_sensitivities_is_refused(copy: Project) -> None:
    sensitivity = copy.build_dir / "sensitivity.h5"
    kept = sensitivity.read_bytes()
    with h5py.File(sensitivity, "a") as file:
        file.attrs["title"] = "another"
    seal(sensitivity)
    imposed_motion(copy, None)
    sensitivity.write_bytes(kept)
    with pytest.raises(InputError, match="stale"), open_results(copy):
        pass
    imposed_motion(copy, None)
    with open_results(copy) as results:
        assert imposed_specs(results)
