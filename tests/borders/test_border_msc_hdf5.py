"""ingest, solve and make-rules where the results are MSC Nastran's HDF5."""

from __future__ import annotations

import shutil
from pathlib import Path

import h5py
import numpy as np
import pytest
from border_tools import CONFIGS, Project, replace, tiny_ids, tiny_motions, untouched
from msc_hdf5_file import DISPLACEMENT, DOMAINS, change_table, table_of, write_msc_hdf5


@pytest.fixture
def msc(tiny: Project) -> tuple[Project, Path]:
    """The two bricks, their unit loads in HDF5."""
    path = tiny.folder / "loads.h5"
    write_msc_hdf5(path, tiny_ids(), tiny_motions(), order=2)
    tiny.op2.unlink()
    replace(tiny.model, '["unit_loads.op2"]', '["loads.h5"]')
    return tiny, path


def test_ingest_says_the_precision_and_keeps_it(msc: tuple[Project, Path]) -> None:
    project, path = msc
    assert "2 thermal areas, displacements in double precision\n" in project.run("ingest").ok().out
    with h5py.File(project.build / "unit_loads.h5") as file:
        assert file["/results/precision"][()] == b"double"
        assert file["/translation"].dtype == np.float64
        for number, (_, _, motion) in enumerate(tiny_motions()[:2]):
            np.testing.assert_array_equal(file["/translation"][number], motion[:, :3])
            np.testing.assert_array_equal(file["/rotation"][number], motion[:, 3:])
    write_msc_hdf5(path, tiny_ids(), tiny_motions(), labels=False)
    assert f"note: {path} has no labels: its subcases are taken by the deck's numbers" in project.run("ingest").ok().out


def test_what_is_refused_leaves_all_as_it_was(msc: tuple[Project, Path]) -> None:
    project, path = msc
    sound = path.read_bytes()

    def refused(code: int, *pieces: str, hint: str = "") -> None:
        with untouched(project.folder):
            project.run("ingest").refused(code, *pieces, hint=hint)
        path.write_bytes(sound)

    rows = table_of(path, DOMAINS)
    rows["SE"][0] = 4
    change_table(path, DOMAINS, rows)
    refused(4, "loads.h5: subcase", "results of superelement 4 are not read", hint="one piece")
    change_table(path, DISPLACEMENT, None)
    refused(4, "loads.h5: holds no displacements", hint="DISPLACEMENT(PLOT) = ALL")
    path.write_bytes(sound[: len(sound) // 2])
    refused(4, "loads.h5: not a readable HDF5 file (truncated or damaged)", hint="is the file complete")
    with h5py.File(path, "w") as file:
        file["time_s"] = np.arange(3.0)
    refused(4, "loads.h5: is HDF5, but not as MSC Nastran writes it", hint="MDLPRM,HDF5")
    shutil.copy(project.build / "unit_loads.h5", path)
    refused(4, "loads.h5: is tedm's own file (tedm.unit_loads)", hint="MDLPRM,HDF5")
    path.unlink()
    refused(4, "loads.h5: no such result file", hint='`tedm solve --run "nastran {deck}"`')


def test_the_place_of_our_own_file(tiny: Project) -> None:
    """MSC Nastran's HDF5 of unit_loads.bdf would be there."""
    replace(tiny.model, '["unit_loads.op2"]', '["build/unit_loads.h5"]')
    for command in (("ingest",), ("solve",), ("solve", "--run", "true {deck}")):
        with untouched(tiny.folder):
            tiny.run(*command).refused(3, "model.op2: names", "where ingest writes", hint="unit_loads.msc.h5")


def test_the_embedded_solver_writes_no_hdf5(msc: tuple[Project, Path]) -> None:
    project, _ = msc
    with untouched(project.folder):
        project.run("solve").refused(3, "model.op2:", "the embedded solver writes an OP2", hint="--run")
        project.run("solve", "-o", project.folder / "x.H5").refused(2, "x.H5 is to be MSC Nastran's HDF5", hint="--run")


def test_make_watches_the_file(msc: tuple[Project, Path]) -> None:
    project, path = msc
    with (project.folder / "tedm.toml").open("a") as file:  # what the cases judge; it need not fit the model for this
        file.write(f'optics = "{CONFIGS / "optics.toml"}"\n')
    project.run("make-rules").ok()
    (said,) = [p for p in project.build.iterdir() if p.is_file() and "OP2 :=" in p.read_text(errors="ignore")]
    assert f"OP2 := {path}\n" in said.read_text()
