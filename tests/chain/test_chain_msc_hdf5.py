"""The small sample's unit loads in MSC Nastran's HDF5: the same [D] as from the OP2, and judged in double precision."""

from __future__ import annotations

import shutil
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np
import pytest
from msc_hdf5_file import write_msc_hdf5

from tedm_cli.config.project import Project, load_project
from tedm_cli.contracts import DISTORTION, UNIT_LOADS
from tedm_cli.errors import PhysicsError
from tedm_cli.files.seal import seal
from tedm_cli.files.store import open_checked
from tedm_cli.nastran.op2.writer import write_op2
from tedm_cli.progress import silent
from tedm_cli.stages.model.distortion import build_distortion
from tedm_cli.stages.model.ingest import ingest
from tedm_cli.stages.model.solve import solve_deck

SMALL = Path(__file__).parents[2] / "sample_models" / "small"
SINGLE = 3e-7  # relative, through an OP2 in single precision
Motions = list[tuple[int, str, np.ndarray]]


@dataclass
class Double:
    """The sample in a folder of its own, with its grids and the motions of the embedded solver as it has them."""

    folder: Path
    ids: np.ndarray
    motions: Motions

    def project(self, *names: str) -> Project:
        model = (SMALL / "model.toml").read_text().replace('["unit_loads.op2"]', str(list(names)).replace("'", '"'))
        (self.folder / "model.toml").write_text(model)
        return load_project(self.folder / "tedm.toml", self.folder / "build")


@pytest.fixture(scope="module")
def double(tmp_path_factory: pytest.TempPathFactory) -> Double:
    folder = tmp_path_factory.mktemp("double")
    for name in ("unit_loads.bdf", "ltp_small_areas.csv"):
        shutil.copy(SMALL / name, folder)
    text = (SMALL / "tedm.toml").read_text()
    assert "../../configs/" in text
    text = text.replace("../../configs/", f"{SMALL.parents[1]}/configs/")
    (folder / "tedm.toml").write_text(text.replace("thermal.toml", f"{SMALL}/thermal.toml"))
    kept = Double(folder, np.zeros(0), [])

    def keep(path: Path, ids: np.ndarray, cases: Iterable[tuple[int, str, np.ndarray]]) -> None:
        kept.ids, kept.motions = ids, [(n, label, motion.copy()) for n, label, motion in cases]
        write_msc_hdf5(path, kept.ids, kept.motions, order=3)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("tedm_cli.stages.model.solve.write_op2", keep)
        solve_deck(folder / "unit_loads.bdf", folder / "loads.h5")
    project = kept.project("loads.h5")
    assert ingest(project, None, silent).precision == "double"
    shutil.copy(project.build_dir / "unit_loads.h5", folder / "sound.h5")
    return kept


def test_the_same_distortion_and_a_sum_to_double_precision(small: Project, double: Double) -> None:
    project = double.project("loads.h5")
    shutil.copy(double.folder / "sound.h5", project.build_dir / "unit_loads.h5")
    done = build_distortion(project, None, silent)
    assert done.precision == "double"
    with (
        open_checked(project.build_dir / "distortion.h5", DISTORTION) as new,
        open_checked(small.build_dir / "distortion.h5", DISTORTION) as old,
    ):
        assert new.strings(DISTORTION.AREA_NAME) == old.strings(DISTORTION.AREA_NAME)
        for path in (DISTORTION.D_TRANSLATION, DISTORTION.D_OPT_TRANSLATION, DISTORTION.D_OPT_ROTATION):
            found, wanted = new.array(path), old.array(path)
            assert 0.0 < np.abs(found - wanted).max() < SINGLE * np.abs(wanted).max()
        for path in (DISTORTION.CHECK_SUPERPOSITION_TRANSLATION, DISTORTION.CHECK_SUPERPOSITION_OPTICS):
            assert new.number(path) < 1e-10
            assert old.number(path) > 1e-8


@pytest.mark.parametrize("where", ["translation", "rotation"])
def test_an_error_that_single_precision_would_hide(double: Double, where: str) -> None:
    """2e-7 of the largest motion: refused in double precision, and within what single precision allows."""
    project = double.project("loads.h5")
    ours = project.build_dir / "unit_loads.h5"
    shutil.copy(double.folder / "sound.h5", ours)
    with h5py.File(ours, "r+") as file:
        data = file["/translation" if where == "translation" else "/rotation"]
        row = int(np.searchsorted(file["/grid/id"][()], 900_001)) if where == "rotation" else 5
        data[3, row, 1] += 2e-7 * np.abs(data[()]).sum(axis=0).max()
    seal(ours)
    with pytest.raises(PhysicsError, match=rf"the {where} of grid .* times what double precision allows") as caught:
        build_distortion(project, None, silent)
    assert caught.value.hint.startswith("single precision would allow it: did the solver iterate")
    with h5py.File(ours, "r+") as file:
        file["/results/precision"][()] = b"single"
    seal(ours)
    assert build_distortion(project, None, silent).precision == "single"


def test_the_coarser_of_two_precisions(double: Double) -> None:
    """Half of the subcases in an OP2, half in HDF5."""
    half = len(double.motions) // 2
    write_op2(double.folder / "half.op2", double.ids, double.motions[:half])
    write_msc_hdf5(double.folder / "half.h5", double.ids, double.motions[half:], labels=False)
    project = double.project("half.h5", "half.op2")
    done = ingest(project, None, silent)
    assert done.precision == "single"
    assert [n for n in done.notes if "labels" in n] == [
        f"{double.folder / 'half.h5'} has no labels: its subcases are taken by the deck's numbers"
    ]
    with open_checked(done.path, UNIT_LOADS) as new, open_checked(double.folder / "sound.h5", UNIT_LOADS) as sound:
        assert new.string(UNIT_LOADS.RESULTS_PRECISION) == "single"
        found, wanted = new.array(UNIT_LOADS.TRANSLATION), sound.array(UNIT_LOADS.TRANSLATION)
    gap = np.abs(found - wanted).max(axis=(1, 2))
    assert (gap[: half - 1] > 0.0).all()
    assert (gap[half:] == 0.0).all()
    assert gap.max() < SINGLE * np.abs(wanted).max()
