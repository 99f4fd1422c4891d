"""The correlations at the bounds of a case: written, put into a configuration, run, and compared with the bounds."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pytest
from border_tools import Project, edited, replace, tedm, untouched

from tedm_cli.noise.bounds import BOUNDS


def append(project: Project, addition: Path) -> None:
    cases = project.folder / "cases.toml"
    cases.write_text(cases.read_text() + "\n" + addition.read_text())


@pytest.mark.parametrize("case", ["3", "late"])
def test_bounds_are_reached_by_the_files_that_are_written(small: Project, case: str) -> None:
    """`late`: two spectra, blocks that are loosened and delayed, silent areas."""
    file = small.folder / "cases.toml"
    white = '[[temperature.override]]\ngroups = ["IS1"]\npreset = "white"\nlevel_K = 1e-5\n\n'
    replace(file, "[[requirement]]", f"{white}[[requirement]]")
    file.write_text(
        file.read_text() + '\n[[case]]\nid = "late"\ntitle = "loose and late"\npartition = "group"\nrho = 0.5\n'
        'groups = ["struts", "flanges", "IS1"]\n'
        'delays = [{ groups = ["struts"], delay_s = 100.0 }, { areas = ["FLANGE_1"], delay_s = 37.0 }]\n'
    )
    small.run("run-case", case).ok()
    outputs = ["TM1_a_x", "A_TM2_x"]
    shown = tedm("export-extremal", case, "--of", outputs[0], "--of", outputs[1], "-d", small.build).ok().out
    assert "5 matrices" not in shown
    assert "10 matrices" in shown
    stem = "case03" if case == "3" else "caselate"
    folder = small.build / "export" / f"{stem}_extremal"
    assert len(list(folder.glob("*.csv"))) == 10
    append(small, folder / "cases.toml")
    ids = [f"{case}_{label}_{bound}" for label in outputs for bound in BOUNDS]
    small.run("run-case", *ids).ok()
    with h5py.File(small.build / f"{stem}.h5") as source:
        labels = [n.decode() for n in source["/output/label"]]
        f = source["/frequency"][()]
        for label in outputs:
            at = int(np.argmin(np.abs(f - source["/contribution/frequency"][labels.index(label)])))
            most = np.sqrt(source[f"/bounds/maximum/{label}"][at])
            for bound in BOUNDS:
                with h5py.File(small.build / f"case{case}_{label}_{bound}.h5") as reached:
                    found = np.sqrt(reached[f"/psd/{label}"][at])
                    # The eigenvectors of R leave the square root of rounding.
                    assert abs(found - np.sqrt(source[f"/bounds/{bound}/{label}"][at])) < 1e-7 * most, (label, bound)
                    if bound == "maximum":  # of signs, which are the same at every frequency
                        np.testing.assert_allclose(
                            reached[f"/psd/{label}"][()], source[f"/bounds/maximum/{label}"][()], rtol=1e-12
                        )


def test_refusals(chain: Project, tmp_path: Path) -> None:
    run = lambda *args: tedm("export-extremal", *args, "-d", chain.build)  # noqa: E731
    run("77").refused(4, "case77.h5: no such file", hint="tedm run-case 77")
    run("3", "--of", "A_TM3_x", "-o", tmp_path / "x").refused(2, "there is no output 'A_TM3_x'; did you mean A_TM")
    (tmp_path / "f").write_text("")
    run("3", "-o", tmp_path / "f").refused(4, "is a file; wanted a folder")
    assert [p.name for p in tmp_path.iterdir()] == ["f"]


def test_a_file_that_lacks_some_of_its_bounds(small: Project) -> None:
    for name, command in (("/extremal/minimum", "export-extremal"), ("/bounds/maximum/A_TM1_x", "export-case")):
        with edited(small.build / "case03.h5") as file:
            del file[name]
        with untouched(small.build):
            tedm(command, "3", "-d", small.build).refused(4, f"case03.h5: has no {name}", hint="tedm run-case")
