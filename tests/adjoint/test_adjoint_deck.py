"""The adjoint by another solver: its deck, and its results, of a plate in mm, t, s that is turned and shifted.

The plate has grids in a cylindrical displacement frame, held feet with mass, grids that depend on an RBE2, an RBE3 and
on equations, and a mass on a grid of no structure. The cards are read by pyNastran, not by what has written them, and
solved by the embedded solver as forces of a user: another way to the same solution.
"""

from __future__ import annotations

import re
import shutil
import sys
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np
import pytest

sys.path += [str(Path(__file__).parents[1] / name) for name in ("", "units", "borders")]

from adjoint_solver import Motions, forces_of, solve_forces
from border_tools import Outcome, tedm, untouched
from msc_hdf5_file import write_msc_hdf5
from plate_instrument import SYSTEMS, TURNED, Instrument, Units, write_project

from tedm_cli.config.project import Project, load_project
from tedm_cli.deck_units import SI, DeckUnits
from tedm_cli.errors import InputError
from tedm_cli.nastran.loads.adjoint_rows import adjoint_rows, read_label
from tedm_cli.nastran.op2.writer import write_op2
from tedm_cli.nastran.reading import read_deck

CASES = """
[temperature]
preset = "white"
outside_K = 1e-3
inside_K = 1e-4

[[case]]
id = "1"
title = "all"
reason = "all"
blocks = [{ areas = ["*"] }]
"""
UNITS = "mm-t-s"
LENGTH, MASS = SYSTEMS[UNITS]
DECK = DeckUnits(LENGTH, MASS)
HANGING = 9777


@dataclass
class Shop:
    """The project in a folder, and what its deck asks for."""

    project: Project

    @property
    def build(self) -> Path:
        return self.project.build_dir

    @property
    def deck(self) -> Path:
        return self.build / "adjoint_loads.bdf"

    def run(self, command: str, *words: object) -> Outcome:
        return tedm(command, *words, "-c", self.project.file.path, "-d", self.build)

    def loads(self) -> list[tuple[str, float, np.ndarray]]:
        """Label, scale and forces [6 N] in N and N·m of every subcase."""
        return [(label, float(label.split(" SCALE ")[1]), force) for label, force in forces_of(self.deck, DECK)]

    def solved(self) -> tuple[np.ndarray, Motions]:
        return solve_forces(self.deck, self.build / "unit_loads.bdf", DECK)


@pytest.fixture(scope="module")
def shop(tmp_path_factory: pytest.TempPathFactory) -> Shop:
    instrument = Instrument(Units(UNITS), TURNED, nx=9, ny=7)
    project = write_project(tmp_path_factory.mktemp("plate"), instrument, f'units = "{UNITS}"')
    model = project.file.path.parent / "model.bdf"
    near = instrument.grid(HANGING, (0.0, 0.1, 0.05)) + f"\nCONM2,{HANGING + 1},{HANGING},,2.-4\n"
    text = model.read_text().replace("SPC = 9\n", "SPC = 9\nTEMPERATURE(MATERIAL) = 5\n", 1)
    model.write_text(text.replace("ENDDATA", near + "TEMP,5,1,99.\nTEMPD,5,20.\nENDDATA"))
    (model.parent / "cases.toml").write_text(CASES)
    made = Shop(project)
    for command in ("write-deck", "solve", "ingest", "build-distortion", "build-sensitivity", "build-optics"):
        made.run(command).ok()
    made.run("build-adjoint").ok()
    made.run("write-deck", "--adjoint").ok()
    return made


@pytest.fixture(scope="module")
def results(shop: Shop) -> tuple[np.ndarray, Motions]:
    return shop.solved()


def array(path: Path, name: str) -> np.ndarray:
    with h5py.File(path) as file:
        return np.asarray(file[name][()])


def strings(path: Path, name: str) -> list[str]:
    with h5py.File(path) as file:
        return [text.decode() for text in file[name][()]]


# --- the deck --------------------------------------------------------------------------------------------------------


def test_its_cards_act_on_the_unit_loads_as_the_outputs_do(shop: Shop) -> None:
    """Their work over the displacements of the unit loads: S_SG, and N without what the faces do; no solution."""
    parts = [array(shop.build / "unit_loads.h5", name) for name in ("/translation", "/rotation")]
    motion = np.concatenate(parts, axis=2)
    found = np.array([scale * force @ motion.reshape(len(motion), -1).T for _, scale, force in shop.loads()])
    adjoint = shop.build / "adjoint.h5"
    blocks = strings(adjoint, "/check/block")
    wanted = np.concatenate([array(shop.build / "sensitivity.h5", "/S"), array(shop.build / "optics.h5", "/N/A")])
    wanted -= array(adjoint, "/direct")
    assert found.shape == wanted.shape
    for block in set(blocks):
        rows = [row for row, name in enumerate(blocks) if name == block]
        assert np.abs(found[rows] - wanted[rows]).max() < 1e-6 * np.abs(wanted[rows]).max(), block


def test_its_subcases(shop: Shop) -> None:
    """Labels that say output and scale, forces of about 1, the constraints of the unit loads, and no temperature."""
    loads = shop.loads()
    assert [name.split(" SCALE ")[0] for name, *_ in loads] == strings(shop.build / "adjoint.h5", "/row/label")
    for label, scale, force in loads:
        assert read_label(label) == (label.split()[0], scale)
        largest = np.abs(force.reshape(-1, 2, 3) / (MASS * LENGTH) / np.array([[1.0], [LENGTH]])).max()
        assert largest == pytest.approx(1.0, abs=1e-5)
    text = shop.deck.read_text()
    control, bulk = text.split("BEGIN BULK")
    unit_control, unit_bulk = (shop.build / "unit_loads.bdf").read_text().split("BEGIN BULK")
    assert "TEMPERATURE(MATERIAL) = 5" in unit_control
    assert "TEMPERATURE" not in control  # which some solvers take for a load
    for line in ("SPC = 9", "MPC = 8", "NSM = 7"):
        assert line in unit_control
        assert line in control
    assert control.count("DISPLACEMENT(PLOT) = ALL") == len(loads) == control.count("  LOAD = ")
    assert bulk.startswith(unit_bulk.removesuffix("ENDDATA\n"))
    selected = {int(n) for n in re.findall(r"LOAD = (\d+)", control)}
    assert not selected & {int(n) for n in re.findall(r"(?m)^TEMPD? +(\d+)", bulk)}


def test_it_loads_grids_of_every_kind(shop: Shop) -> None:
    """The feet, which are held, have a frame of their own and mass; what hangs on nothing; grids that depend."""
    ids = np.array(sorted(read_deck(shop.deck, cross_reference=False, units=DECK).nodes))
    by_output = {name.split()[0]: np.flatnonzero(force.reshape(-1, 6).any(axis=1)) for name, _, force in shop.loads()}
    gravity, read_out = set(ids[by_output["TM1_a_x"]].tolist()), set(ids[by_output["A_TM1_x"]].tolist())
    assert {9020, HANGING, 9001, 1} <= gravity | {9001}
    assert read_out == {9001, 9002, 9003, 9004}


def moved(shop: Shop, folder: Path) -> Shop:
    """A copy with its own files."""
    shutil.copytree(shop.project.file.path.parent, folder / "copy")
    return Shop(load_project(folder / "copy" / "tedm.toml", folder / "copy" / "build"))


def test_what_is_written_is_told(shop: Shop, tmp_path: Path) -> None:
    said = shop.run("write-deck", "--adjoint", "-o", tmp_path / "own.bdf").ok().out
    assert re.match(r".*/own\.bdf: 9 outputs as loads of [\d,]+ cards on 80 grids$", said.splitlines()[0])
    assert (tmp_path / "own.bdf").read_bytes() == shop.deck.read_bytes()


def test_outputs_that_nothing_acts_on_have_no_subcase() -> None:
    force = np.zeros((12, 3))
    force[0, 0], force[11, 2] = 2e-9, -3.0
    rows = adjoint_rows(["TM1_a_x", "TM1_omegadot_x", "A_TM1_x"], force, SI, "deck.bdf")
    assert [row.label for row in rows] == ["TM1_a_x SCALE 2.00000E-09", "A_TM1_x SCALE 3.00000E+00"]
    assert rows[1].load[1, 5] == -1.0
    force[3, 0] = 1e-45
    assert adjoint_rows(["a", "b", "c"], force, SI, "")[0].load[0, 3] == 0.0


def test_names_that_no_label_holds() -> None:
    with pytest.raises(InputError, match="a LABEL has room for 38"):
        adjoint_rows([39 * "x"], np.ones((6, 1)), SI, "deck.bdf")
    adjoint_rows([38 * "x"], np.ones((6, 1)), SI, "deck.bdf")
    with pytest.raises(InputError, match="outputs tm_a_x and TM_a_x differ in their case alone"):
        adjoint_rows(["tm_a_x", "TM_a_x"], np.ones((6, 2)), SI, "deck.bdf")


# --- the results -----------------------------------------------------------------------------------------------------


def test_double_precision_gives_the_embedded_adjoint(shop: Shop, results, tmp_path: Path) -> None:
    """From MSC's HDF5, subcases in another order: every dataset, materials and shells too, and sums to 1e-6."""
    ids, cases = results
    write_msc_hdf5(tmp_path / "adjoint.msc.h5", ids, cases, order=3)
    said = shop.run("build-adjoint", "--op2", tmp_path / "adjoint.msc.h5", "-o", tmp_path / "found.h5").ok().out
    assert "solutions from" in said
    assert "single precision" not in said
    with h5py.File(shop.build / "adjoint.h5") as ours, h5py.File(tmp_path / "found.h5") as found:
        names: list[str] = []
        ours.visititems(lambda name, item: names.append(name) if isinstance(item, h5py.Dataset) else None)
        assert {"s", "map/s", "material/dS_dlnE", "shell/dS_dlnt", "area/gradient"} <= set(names)
        block = ours["check/block"][()]
        for name in sorted(names):
            a, b = ours[name][()], found[name][()]
            if name.startswith("provenance"):
                assert len(found["provenance/input_path"]) == 1 + len(ours["provenance/input_path"])
            elif name == "check/residual":
                assert np.isnan(b)
            elif name == "area/cancellation" or name.startswith("check/diff"):
                continue  # quotients of what is nearly nothing
            elif a.dtype.kind == "f" and len(block) in a.shape:
                a, b = (np.nan_to_num(np.moveaxis(x, x.shape.index(len(block)), 0)) for x in (a, b))
                for one in set(block):
                    size = np.abs(a[block == one]).max()
                    np.testing.assert_allclose(b[block == one], a[block == one], rtol=0, atol=2e-8 * size, err_msg=name)
            else:
                np.testing.assert_array_equal(a, b, err_msg=name)
        assert (found["check/difference"][()] <= ours["check/allowed"][()]).all()


def test_single_precision_is_judged_as_such(shop: Shop, results, tmp_path: Path) -> None:
    """An OP2: the differences are more than those of double precision, and no more than what is allowed."""
    ids, cases = results
    write_op2(tmp_path / "adjoint.op2", ids, cases)
    said = shop.run("build-adjoint", "--op2", tmp_path / "adjoint.op2", "-o", tmp_path / "found.h5").ok().out
    assert "they are in single precision, which may change a sum by" in said
    found, ours = tmp_path / "found.h5", shop.build / "adjoint.h5"
    difference, allowed = array(found, "/check/difference"), array(found, "/check/allowed")
    assert difference.max() > 10 * array(ours, "/check/difference").max()
    share = (difference / allowed).max()
    assert 0.01 < share < 1.0
    blocks = strings(ours, "/check/block")
    for row, block in enumerate(blocks):
        rows = [k for k, name in enumerate(blocks) if name == block]
        size = np.abs(array(ours, "/area/sum")[rows]).max()
        off = np.abs(array(found, "/area/sum")[row] - array(ours, "/area/sum")[row]) / size
        assert (off <= allowed[row]).all(), block


@pytest.fixture(scope="module")
def op2(shop: Shop, results, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("results") / "adjoint.op2"
    write_op2(path, *results)
    return path


def test_the_configuration_may_name_them(shop: Shop, op2: Path, tmp_path: Path) -> None:
    """In two files; the chain is made of them, and anew when they change."""
    copy = moved(shop, tmp_path)
    ids, cases = copy.solved()
    folder = copy.project.file.path.parent
    write_op2(folder / "first.op2", ids, cases[::2])
    write_op2(folder / "second.op2", ids, cases[1::2])
    model = folder / "model.toml"
    model.write_text(model.read_text().replace("[model]\n", '[model]\nadjoint_op2 = ["first.op2", "second.op2"]\n'))
    copy.run("run", "build-adjoint").ok()
    both = tmp_path / "both.h5"
    shop.run("build-adjoint", "--op2", op2, "-o", both).ok()
    assert np.array_equal(array(copy.build / "adjoint.h5", "/s"), array(both, "/s"))
    tedm("check", "-d", copy.build).ok()
    write_op2(folder / "first.op2", ids, [(n, label, 1.001 * m) for n, label, m in cases[::2]])
    assert "first.op2 is newer" in copy.run("run", "build-adjoint", "-n").ok().out
    (folder / "second.op2").unlink()
    with untouched(copy.build):
        copy.run("build-adjoint").refused(4, "second.op2: no such results", hint="tedm write-deck --adjoint")
        copy.run("run", "build-adjoint").refused(4, "second.op2: no such file", hint="tedm write-deck --adjoint")


def changed(cases, change):
    """The cases as `change` makes them of number, label and motion; None leaves one out."""
    return [case for case in (change(*case) for case in cases) if case is not None]


REFUSED = {
    "a subcase missing": (
        lambda n, label, m: None if label.startswith("TM1_a_y") else (n, label, m),
        ("no displacements for 1 of 9 outputs: TM1_a_y",),
        "before its last subcase",
    ),
    "other outputs": (
        lambda n, label, m: (n, label.replace("TM1", "TMX"), m),
        ("subcase 1: is of TMX_a_x, which is no output of the matrices",),
        "optics.h5 missing",
    ),
    "unit loads": (
        lambda n, label, m: (n, "PLATE_BACK", m),
        ("subcase 1: is not of an adjoint deck (label 'PLATE_BACK')",),
        "write-deck --adjoint",
    ),
    "of other matrices": (
        lambda n, label, m: (n, re.sub(r"SCALE \d\.\d+", "SCALE 1.23456", label), m),
        ("subcase 1: is of other matrices: the scale of TM1_a_x is 1.23456E",),
        "write-deck --adjoint",
    ),
    "one twice": (
        lambda n, label, m: (n, label.replace("_a_y", "_a_x"), m),
        ("subcase 2: is of other matrices",),
        "write-deck --adjoint",
    ),
    "not a number": (
        lambda n, label, m: (n, label, np.where(np.arange(6) == 2, np.nan, m) if n == 4 else m),
        ("subcase 4 (TM1_omegadot_x)", "NaN or infinite"),
        "fail in this subcase",
    ),
}


@pytest.mark.parametrize("case", [*REFUSED])
def test_other_results_are_refused(shop: Shop, results, tmp_path: Path, case: str) -> None:
    """In one clear error, also where the chain asks; nothing is written."""
    change, pieces, hint = REFUSED[case]
    ids, cases = results
    write_msc_hdf5(tmp_path / "adjoint.msc.h5", ids, changed(cases, change))
    with untouched(shop.build):
        said = shop.run("build-adjoint", "--or-say-why", "--op2", tmp_path / "adjoint.msc.h5")
    said.refused(4, *pieces, hint=hint)


def test_results_of_another_model_are_refused(shop: Shop, results, tmp_path: Path) -> None:
    ids, cases = results
    path = tmp_path / "adjoint.op2"
    write_op2(path, ids + 500_000, cases)
    shop.run("build-adjoint", "--op2", path).refused(4, "80 grids are not in the deck: 500001", hint="another model")
    write_op2(path, ids[5:], [(n, label, m[5:]) for n, label, m in cases])
    shop.run("build-adjoint", "--op2", path).refused(4, "5 grids have no displacement: 1, 2")
    write_op2(path, ids, cases)
    shop.run("build-adjoint", "--op2", path, "--op2", path).refused(4, "output TM1_a_x was already in", "subcase 1")
    write_msc_hdf5(tmp_path / "bare.h5", ids, cases, labels=False)
    shop.run("build-adjoint", "--op2", tmp_path / "bare.h5").refused(4, "has no labels, which tell the output")
    path.write_bytes(path.read_bytes()[:-900])
    shop.run("build-adjoint", "--op2", path).refused(4, "truncated or damaged")
    shop.run("build-adjoint", "--op2", tmp_path / "bare.h5", "-o", tmp_path / "bare.h5").refused(4, "its own file")


def test_a_disagreement_names_area_and_output(shop: Shop, results, tmp_path: Path) -> None:
    """As of a deck of another stiffness: one solution a hundredth larger."""
    ids, cases = results
    write_msc_hdf5(
        tmp_path / "a.h5", ids, changed(cases, lambda n, label, m: (n, label, m * (1.01 if n == 9 else 1.0)))
    )
    label = cases[8][1].split()[0]
    with untouched(shop.build):
        shop.run("build-adjoint", "--op2", tmp_path / "a.h5").refused(
            5, "a.h5: the adjoint's sum over area '", f"in {label} by", hint="was the adjoint deck written before"
        )


# --- what the deck is not written of ---------------------------------------------------------------------------------


def test_without_matrices_of_this_deck_nothing_is_written(shop: Shop, tmp_path: Path) -> None:
    copy = moved(shop, tmp_path)
    copy.deck.unlink()
    (copy.build / "optics.h5").unlink()
    assert "no read-outs: " in copy.run("write-deck", "--adjoint", "-o", tmp_path / "x.bdf").ok().out.splitlines()[0]
    (copy.build / "sensitivity.h5").unlink()
    copy.run("write-deck", "--adjoint").refused(4, "sensitivity.h5: no such file", hint="tedm build-sensitivity")
    shutil.copy(shop.build / "sensitivity.h5", copy.build)
    deck = copy.build / "unit_loads.bdf"
    deck.write_text(deck.read_text() + "$ changed\n")
    copy.run("write-deck", "--adjoint").refused(4, "unit_loads.h5: is stale", hint="tedm ingest")
    deck.write_text(deck.read_text().replace("$ changed\n", ""))
    copy.run("write-deck", "--adjoint", "-o", deck).refused(4, "is a file of the model itself")
    assert not copy.deck.exists()
