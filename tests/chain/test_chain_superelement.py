"""A spacecraft as a superelement against the whole model: the same D, S and field at rest, and what is refused."""

from __future__ import annotations

import re
import struct
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np
import pytest
from spacecraft_frame import BOX, FEET, HUNG, Frame

from tedm_cli.arrays import FloatArray
from tedm_cli.config.loads import LoadsConfig
from tedm_cli.config.project import Project, load_project
from tedm_cli.errors import ConfigError, InputError, TedmError
from tedm_cli.nastran.reading import read_deck
from tedm_cli.nastran.superelements.deck import STIFFNESS
from tedm_cli.nastran.superelements.dmig import entries_of, six
from tedm_cli.nastran.superelements.files import MatrixNames, read_matrices
from tedm_cli.progress import silent
from tedm_cli.stages.adjoint.build import build_adjoint
from tedm_cli.stages.gravity.sensitivity import build_sensitivity
from tedm_cli.stages.loads.model import loaded_model
from tedm_cli.stages.model.areas import areas
from tedm_cli.stages.model.deck import write_deck
from tedm_cli.stages.model.distortion import build_distortion
from tedm_cli.stages.model.ingest import ingest
from tedm_cli.stages.model.reduce import reduce
from tedm_cli.stages.model.solve import solve


@dataclass(frozen=True)
class Both:
    """The chain of the whole model, and that of the instrument with its spacecraft reduced."""

    whole: Project
    rest: Project
    suffix: str
    held: bool

    def arrays(self, file: str, name: str) -> tuple[FloatArray, FloatArray]:
        """Of both, by areas in one order."""
        out = []
        for project in (self.whole, self.rest):
            with h5py.File(project.build_dir / f"{file}.h5") as h5:
                names = [n.decode() for n in h5["area/name"][()]]
                values, order = h5[name][()], np.argsort(names)
                axis = next((n for n, size in enumerate(values.shape) if size == len(order)), None)
                out.append(values if axis is None else np.take(values, order, axis))
        return out[0], out[1]


def run(project: Project) -> None:
    write_deck(project, None)
    solve(project, None, silent)
    ingest(project, None, silent)
    build_distortion(project, None, silent)
    build_sensitivity(project, None, silent)


def reduced(folder: Path, frame: Frame, suffix: str = ".op4") -> tuple[Project, Project]:
    """Both projects, with the superelement made of the whole one's deck."""
    whole = frame.project(folder / "whole", whole=True)
    write_deck(whole, None)
    done = reduce(whole, list(FEET), HUNG, folder / f"sc{suffix}")
    table = "\n" + "\n".join(done.table) + "\n"
    table = re.sub(r'"(sc[^"]*\.\w+)"', r'"../\1"', table)
    assert ("grounded" in table) == frame.held
    rest = frame.project(folder / "rest", whole=False, table=table)
    return whole, rest


@pytest.fixture(
    scope="module",
    params=[(Frame(), ".op4"), (Frame(mm=True), ".bdf"), (Frame(held=True), ".op4")],
    ids=["free", "in mm by DMIG", "held at the plate"],
)
def both(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Both:
    whole, rest = reduced(tmp_path_factory.mktemp("superelement"), *request.param)
    for project in (whole, rest):
        run(project)
    return Both(whole, rest, request.param[1], request.param[0].held)


def test_motions_are_those_of_the_whole_model(both: Both) -> None:
    """Each grid under each load, over the largest motion. Results have single precision, DMIG ten digits."""
    tolerance = 5e-6 if both.suffix == ".bdf" else 1e-6
    ids = []
    for project in (both.whole, both.rest):
        with h5py.File(project.build_dir / "unit_loads.h5") as h5:
            ids.append(h5["grid/id"][()])
    common = np.intersect1d(*ids)
    assert len(common) > 30
    assert {1, *FEET, HUNG} < set(common.tolist())
    for name in ("translation", "rotation"):
        wanted, found = (
            values[:, np.searchsorted(grids, common)]
            for values, grids in zip(both.arrays("unit_loads", name), ids, strict=True)
        )
        scale = np.abs(wanted).max(axis=(1, 2), keepdims=True)
        print(name, (np.abs(found - wanted) / scale).max())
        assert (np.abs(found - wanted) / scale).max() < tolerance


@pytest.mark.parametrize(
    ("name", "tolerance"),
    [("S", 1e-6), ("dc/acceleration", 1e-9), ("stiffness/linearised", 1e-9), ("area_contribution/acceleration", 1e-9)],
)
def test_gravity_is_that_of_the_whole_model(both: Both, name: str, tolerance: float) -> None:
    """By lumped masses, of which all are recovered: S and the field at rest, area by area."""
    wanted, found = both.arrays("sensitivity", name)
    if name == "S":
        assert np.abs(wanted[:, -2:]).max() > 0.1 * np.abs(wanted).max()  # the areas of the plate
    np.testing.assert_allclose(found, wanted, rtol=0, atol=tolerance * np.abs(wanted).max())


def test_areas_have_place_and_mass(both: Both) -> None:
    for name in ("area/centroid", "area/mass"):
        wanted, found = both.arrays("unit_loads", name)
        np.testing.assert_allclose(found, wanted, rtol=1e-9, atol=1e-12)
    listed = areas(both.rest, None, None)
    assert sorted(listed.table.name.tolist()) == ["FEET", "FRAME_A", "FRAME_B", "PLATE_A", "PLATE_B"]
    assert listed.is_partition


def test_no_adjoint(both: Both) -> None:
    with pytest.raises(InputError, match="has a superelement, of which temperatures"):
        build_adjoint(both.rest, None, silent)


def test_no_effect_of_loads(both: Both) -> None:
    with pytest.raises(InputError, match="has a superelement, whose mass is not in the matrices"):
        loaded_model(both.rest, LoadsConfig(), Path("loads.toml"))


def test_a_free_spacecraft_is_made_free(both: Both) -> None:
    """Its stiffness in the deck leaves rigid motions without force, far beyond the digits of a card."""
    model = read_deck(both.rest.build_dir / "unit_loads.bdf", cross_reference=False)
    grids = sorted(FEET)
    parts = [entries_of(model, name, (6,), "") for name in STIFFNESS]
    k = sum(one.dense(six(grids), six(grids), "") for one in parts)
    shift = np.tile(np.eye(6)[:, 2], len(grids))  # along z, also of the foot in a cylindrical frame about z
    force = np.abs(k @ shift).max() / np.abs(k).max()
    assert force > 1e-6 if both.held else force < 1e-14


def broken(folder: Path, change: tuple[str, str], csv: tuple[str, str, str] | None = None) -> TedmError:
    """What write-deck says of a model.toml, or of a list, after a change."""
    _, rest = reduced(folder, Frame())
    text = rest.model.read_text()
    assert change[0] in text
    rest.model.write_text(text.replace(*change, 1))
    if csv is not None:
        path = folder / f"sc_{csv[0]}.csv"
        listed = path.read_text()
        assert csv[1] in listed
        path.write_text(listed.replace(csv[1], csv[2], 1))
    again = load_project(rest.file.path, rest.build_dir)
    with pytest.raises(TedmError) as caught:
        write_deck(again, None)
    assert not (rest.build_dir / "unit_loads.bdf").exists()
    return caught.value


SAME = ("[model]", "[model]")
MASSLESS = ('masses = "../sc_masses.csv"\n', "")


@pytest.mark.parametrize(
    ("change", "csv", "kind", "fact"),
    [
        (("interface = [11,", "interface = [999,"), None, ConfigError, "the deck has no grid 999"),
        (("interface = [11, 12,", "interface = [12, 11,"), None, InputError, "resists a rigid motion"),
        (("interface = [11,", "interface = [12,"), None, ConfigError, "grid 12 is there twice"),
        (("interface = [11, 12, 13, 14]", "interface = [11, 12, 13, 14, 1]"), None, InputError, "have 30 freedoms"),
        (('shared = ["FEET"]', ""), None, InputError, "area 'FEET' of superelement 'sc' is one of the deck already"),
        (('shared = ["FEET"]', 'shared = ["KNEES"]'), None, InputError, "does not have the shared area 'KNEES'"),
        (MASSLESS, ("areas", "PLATE_A", "FRAME_A"), InputError, "area 'FRAME_A' of superelement"),
        (SAME, ("areas", "PLATE_B", "PLATE_A"), InputError, "is in line"),
        (MASSLESS, ("areas", "PLATE_B", "UNIFORM"), InputError, "area 'UNIFORM' of superelement"),
        (SAME, ("masses", f"\n{HUNG},", "\n4,"), InputError, "grid 4 with mass is in the deck already"),
        (SAME, ("masses", "PLATE_B", "PLATE_C"), InputError, "there is no area 'PLATE_C'"),
        (SAME, ("masses", f"\n{HUNG},0.3", f"\n{HUNG},0.5"), InputError, f"grid {HUNG} does not follow"),
        (('"../sc.op4"', '"../none.op4"'), None, InputError, "no such file of matrices"),
        (("[[superelement]]", '[[superelement]]\nrecovery = "KAA"'), None, InputError, "KAA is 24 x 24, wanted"),
        (("[[superelement]]", '[[superelement]]\nloads = "XX"'), None, InputError, "has no matrix XX; there are: GRA"),
    ],
)
def test_one_clear_error(tmp_path, change, csv, kind, fact) -> None:
    error = broken(tmp_path, change, csv)
    assert isinstance(error, kind)
    assert fact in str(error)


def test_a_row_that_a_dmig_lacks(tmp_path: Path) -> None:
    _, rest = reduced(tmp_path, Frame(), ".bdf")
    path = tmp_path / "sc.bdf"
    text = path.read_text()
    path.write_text(re.sub(rf"(?m)^(\*\s+){HUNG}(\s+\d)", rf"\g<1>{BOX}\2", text))
    with pytest.raises(InputError, match=f"recovery GRA has no row of grid {HUNG}"):
        write_deck(rest, None)
    path.write_text(re.sub(r"D[+-]0", "D+x", text, count=1))
    with pytest.raises(InputError, match="cannot be read as DMIG cards"):
        write_deck(rest, None)


def test_an_interface_that_divides_nothing(tmp_path: Path) -> None:
    whole = Frame().project(tmp_path / "whole", whole=True)
    write_deck(whole, None)
    with pytest.raises(InputError, match="cuts nothing off"):
        reduce(whole, list(FEET[:2]), HUNG, None)


def test_a_binary_file(tmp_path: Path) -> None:
    """As Nastran writes OUTPUT4: records of columns from their first to their last entry."""
    random = np.random.default_rng(2)
    half = random.standard_normal((13, 13))
    matrices = {"KAA": half @ half.T, "PA": random.standard_normal((13, 2))}
    matrices["PA"][:4, 0] = 0.0
    path = tmp_path / "sc.op4"
    with path.open("wb") as file:
        for name, a in matrices.items():
            records = [struct.pack("<4i", a.shape[1], a.shape[0], 2, 2) + name.ljust(8).encode()]
            for j, column in enumerate(a.T, start=1):
                first = int(np.flatnonzero(column)[0])
                records.append(struct.pack("<3i", j, first + 1, 2 * (13 - first)) + column[first:].tobytes())
            records.append(struct.pack("<3id", a.shape[1] + 1, 1, 1, 1.0))
            file.writelines(struct.pack("<i", len(r)) + r + struct.pack("<i", len(r)) for r in records)
    read = read_matrices(path, MatrixNames(), np.array([4, 2]), 2, np.zeros(0, dtype=np.int64))
    np.testing.assert_array_equal(read.stiffness, matrices["KAA"])
    np.testing.assert_array_equal(read.loads, matrices["PA"])
    path.write_bytes(path.read_bytes()[:700])
    with pytest.raises(InputError, match="cannot be read as OUTPUT4"):
        read_matrices(path, MatrixNames(), np.array([4, 2]), 2, np.zeros(0, dtype=np.int64))
