"""The plate instrument in other units, and turned and shifted: the same D, S and N from every deck.

A solver's results are in single precision, in the units and the frame of its deck. So D, its largest entries for scale,
is the same to some 1e-7, and the masses and the field at rest, which need no results, to the digits of the cards.
"""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np
import pytest
from plate_instrument import TRACKED, TURNED, Instrument, Place, Units, write_project

from tedm_cli.arrays import FloatArray
from tedm_cli.cli.printing.ingest import unit_lines
from tedm_cli.config.model.file import load_model
from tedm_cli.config.project import Project, load_project
from tedm_cli.deck_units import SI
from tedm_cli.fem.static import StaticSolution
from tedm_cli.nastran.op2.reader import open_op2
from tedm_cli.nastran.structure.deck import read_solver_deck
from tedm_cli.progress import silent
from tedm_cli.stages.gravity.sensitivity import build_sensitivity
from tedm_cli.stages.model.areas import areas
from tedm_cli.stages.model.deck import DeckSummary, write_deck
from tedm_cli.stages.model.distortion import build_distortion
from tedm_cli.stages.model.ingest import IngestSummary, ingest
from tedm_cli.stages.model.solve import solve, solve_elsewhere
from tedm_cli.stages.optics.build import build_optics

SINGLE = 2.0**-24  # rounding of a component, over the vector it belongs to where frames differ


@dataclass(frozen=True)
class Built:
    """What the chain made of an instrument, with vectors in the frame of the layout."""

    project: Project
    place: Place
    deck: DeckSummary
    read: IngestSummary

    def array(self, file: str, name: str) -> FloatArray:
        with h5py.File(self.project.build_dir / f"{file}.h5") as h5:
            return np.asarray(h5[name][()])

    def vectors(self, file: str, name: str) -> FloatArray:
        return np.asarray(self.array(file, name) @ self.place.turn)

    @property
    def bdf(self) -> Path:
        return self.project.build_dir / "unit_loads.bdf"


def small(units: Units = Units()) -> Instrument:
    return Instrument(units, nx=9, ny=7)


def build(folder: Path, instrument: Instrument, keys: str = "") -> Built:
    project = write_project(folder, instrument, keys)
    deck = write_deck(project, None)
    solve(project, None, silent)
    read = ingest(project, None, silent)
    build_distortion(project, None, silent)
    build_sensitivity(project, None, silent)
    build_optics(project, None)
    return Built(project, instrument.place, deck, read)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("plate")


@pytest.fixture(scope="module")
def plate(folder: Path) -> Built:
    return build(folder / "plate", Instrument())


@pytest.fixture(scope="module")
def turned(folder: Path) -> Built:
    return build(folder / "turned", Instrument(place=TURNED))


@pytest.fixture(scope="module")
def coarse(folder: Path) -> Built:
    return build(folder / "coarse", small())


@pytest.fixture(scope="module")
def weighed(folder: Path) -> Built:
    """In pounds-force and inches, densities as weights, in degrees Fahrenheit."""
    units = Units("in-lbf-s", fahrenheit=True, wtmass=0.0025900790)
    return build(folder / "weighed", small(units), 'units = "in-lbf-s"\ntemperature = "degF"')


def test_the_plate_is_an_instrument(plate: Built) -> None:
    """Every part of it matters to what is compared: of the order of what the bench itself does."""
    assert plate.read.grids == 973
    assert plate.read.elements == 896 + 14
    n, s = plate.array("optics", "/N/A"), plate.array("sensitivity", "/S")
    assert (np.abs(n).max(axis=1) > 1e-8).all()
    assert (np.abs(s) > 1e-17).all()
    moved = plate.array("distortion", "/D_opt/translation")
    assert (np.abs(moved).max(axis=(0, 2)) > 1e-6).all()


def same_files(wanted: Built, found: Built, digits: float) -> None:
    """What is read of the decks is the same to the digits of their cards; D, S and N to single precision."""
    for name in ("/grid/position", "/mass/lumped", "/mass/inertia", "/element/density", "/element/expansion"):
        a, b = (built.array("unit_loads", name) for built in (wanted, found))
        np.testing.assert_allclose(b, a, rtol=0, atol=digits * np.abs(a).max(), err_msg=name)
    for name in ("/element/section", "/element/lever", "/mass/concentrated_lever"):
        a, b = (built.array("unit_loads", name) for built in (wanted, found))
        np.testing.assert_allclose(b, a, rtol=0, atol=digits * np.abs(a).max(), err_msg=name)
    np.testing.assert_allclose(found.array("unit_loads", "/area/load_K"), 1.0, rtol=1e-14)
    assert found.array("unit_loads", "/uniform/load_K") == pytest.approx(1.0, rel=1e-14)
    at_rest = [built.array("sensitivity", "/dc/acceleration") for built in (wanted, found)]
    np.testing.assert_allclose(at_rest[1], at_rest[0], rtol=0, atol=10 * digits * np.abs(at_rest[0]).max())
    for file, name in (
        ("distortion", "/D/translation"),
        ("distortion", "/D_opt/translation"),
        ("distortion", "/D_opt/rotation"),
    ):
        a, b = (built.array(file, name) for built in (wanted, found))
        np.testing.assert_allclose(b, a, rtol=0, atol=4 * SINGLE * np.abs(a).max(), err_msg=name)
    for file, name in (("sensitivity", "/S"), ("optics", "/N/A")):
        a, b = (built.array(file, name) for built in (wanted, found))
        assert (np.abs(b - a).max(axis=1) < 1e-6 * np.abs(a).max(axis=1)).all(), name


def test_in_millimetres_and_tonnes(plate: Built, folder: Path) -> None:
    same_files(plate, build(folder / "mm-t-s", Instrument(Units("mm-t-s")), 'units = "mm-t-s"'), 1e-12)


def test_in_pounds_and_degrees_fahrenheit(coarse: Built, weighed: Built) -> None:
    """Densities, point masses and non-structural masses go through PARAM,WTMASS once."""
    same_files(coarse, weighed, 1e-9)  # of a factor with eight digits
    assert weighed.read.masses.properties.mass_kg == pytest.approx(coarse.read.masses.properties.mass_kg, rel=1e-9)


@pytest.mark.parametrize(
    ("units", "keys"),
    [
        (Units("mm-kg-s"), 'units = "mm-kg-s"'),
        (Units("in-lbf-s"), "length_m = 0.0254\nmass_kg = 175.12683524647636\ntime_s = 1.0"),
    ],
)
def test_in_other_systems(coarse: Built, folder: Path, units: Units, keys: str) -> None:
    same_files(coarse, build(folder / units.name, small(units), keys), 1e-11)


def test_areas_are_of_the_same_grids(coarse: Built, weighed: Built) -> None:
    """Boxes are in metres of a frame of the deck, whatever its units."""
    wanted, found = (areas(built.project, None, None) for built in (coarse, weighed))
    for name, ids in wanted.on_grids.items():
        np.testing.assert_array_equal(found.on_grids[name], ids)
    assert len(wanted.on_grids) == len(wanted.loads)
    np.testing.assert_allclose(found.mass_kg, wanted.mass_kg, rtol=1e-9)
    np.testing.assert_allclose(found.centroid_m, wanted.centroid_m, rtol=0, atol=1e-12)


def test_what_is_written_keeps_the_units_of_the_deck(coarse: Built, weighed: Built) -> None:
    """The user's Nastran would write the same: its cards, steps in its degrees, displacements in its lengths."""
    model = (weighed.project.model.parent / "model.bdf").read_text(encoding="ascii")
    text = weighed.bdf.read_text(encoding="ascii")
    assert model.partition("BEGIN BULK\n")[2].removesuffix("ENDDATA\n") in text
    assert (weighed.deck.reference, weighed.deck.temperature) == (68.0, "degF")
    assert "\nTEMPD          1     68.\n" in text
    assert {line.split()[3] for line in text.splitlines() if line.startswith("TEMP ")} == {"69.8"}
    motions = []
    for built in (coarse, weighed):
        with open_op2(built.project.build_dir / "unit_loads.op2") as (tables, read):
            motions.append(np.stack([read(table).motion for table in tables]))
    for part, factor in ((slice(0, 3), 1.0 / 0.0254), (slice(3, 6), 1.0)):
        a, b = (m[:, :, part] for m in motions)
        np.testing.assert_allclose(b, factor * a, rtol=0, atol=4 * SINGLE * np.abs(factor * a).max())


def test_a_reference_temperature_is_in_kelvin(weighed: Built, tmp_path: Path) -> None:
    keys = 'units = "in-lbf-s"\ntemperature = "{}"\nreference_temperature_K = 293.15'
    for scale, shown in (("degF", 68.0), ("degC", 20.0), ("K", 293.15)):
        project = write_project(tmp_path / scale, small(Units("in-lbf-s")), keys.format(scale))
        assert write_deck(project, None).reference == shown


def test_a_nastran_of_ones_own_is_given_the_deck_in_its_units(weighed: Built, tmp_path: Path) -> None:
    """A plate of 150 inches is none of 150 m; the stand-in for a solver copies results that are there."""
    folder = shutil.copytree(weighed.project.model.parent, tmp_path / "elsewhere")
    project = load_project(folder / "tedm.toml", folder / "build")
    deck, results = folder / "build" / "unit_loads.bdf", weighed.project.build_dir / "unit_loads.op2"
    text = deck.read_text(encoding="ascii").replace("ENDDATA", "PSHELL        99       1    150.\nENDDATA")
    deck.write_text(text, encoding="ascii")
    command = f"sh -c 'cp {results} ${{1%.bdf}}.op2' sh {{deck}}"
    out, subcases = solve_elsewhere(project, None, command, lambda line: None)
    assert (out.read_bytes(), subcases) == (results.read_bytes(), 6)


def test_a_scale_of_temperature_that_was_forgotten(weighed: Built, tmp_path: Path) -> None:
    """No number of a deck tells it: [D] would be per degree Fahrenheit, too small by 1.8."""
    told = [note for note in (*weighed.deck.notes, *weighed.read.notes) if "degF" in note]
    assert told == []
    folder = shutil.copytree(weighed.project.model.parent, tmp_path / "forgotten")
    model = folder / "model.toml"
    model.write_text(model.read_text(encoding="utf-8").replace('temperature = "degF"\n', ""), encoding="utf-8")
    project = load_project(folder / "tedm.toml", folder / "build")
    written, read = write_deck(project, folder / "other.bdf"), ingest(project, None, silent)
    assert [note.partition(":")[0] for note in written.notes[:1]] == ["temperatures and expansions are taken in kelvin"]
    assert [note.partition(":")[0] for note in read.notes[:2]] == [
        "temperatures and expansions are taken in kelvin",
        "every step is 1.8 K",
    ]
    assert unit_lines(read.units) == ['deck and results: units = "in-lbf-s", temperature = "K"']
    assert unit_lines(SI) == []


def test_turned_and_shifted(plate: Built, turned: Built) -> None:
    """D turns with the model, S is that of the test mass's own axes, N that of the layout's."""
    at_rest = [built.array("sensitivity", "/dc/acceleration") for built in (plate, turned)]
    np.testing.assert_allclose(at_rest[1], at_rest[0], rtol=0, atol=1e-12 * np.abs(at_rest[0]).max())
    for name in ("/D/translation", "/D_opt/translation", "/D_opt/rotation"):
        a, b = (built.vectors("distortion", name) for built in (plate, turned))
        np.testing.assert_allclose(b, a, rtol=0, atol=6 * SINGLE * np.abs(a).max(), err_msg=name)
    s = [built.array("sensitivity", "/S") for built in (plate, turned)]
    assert (np.abs(s[1] - s[0]).max(axis=1) < 1e-6 * np.abs(s[0]).max(axis=1)).all()


def read_out_of_exact_motions(built: Built) -> tuple[FloatArray, FloatArray]:
    """N of the motions as they are solved, in double precision, and of what single precision may make of it."""
    structure, cases = read_solver_deck(built.bdf, load_model(built.project.model)[1].model.deck_units())
    rows = np.searchsorted(structure.grid_id, list(TRACKED.values()))
    solved = dict(StaticSolution(structure).solve(cases))
    motion = np.stack([solved[c.id][rows] for c in cases if c.label != "UNIFORM"])
    vector = motion.reshape(len(motion), -1, 3) @ built.place.turn  # of the optical elements, in the layout's frame
    gain = built.array("optics", "/gain/A")[:, 6:]  # the test mass, first, does not move
    length = np.repeat(np.linalg.norm(vector, axis=2), 3, axis=1)
    return gain @ vector.reshape(len(motion), -1).T, SINGLE * np.abs(gain) @ length.T


def test_read_out_of_the_turned_model(plate: Built, turned: Built) -> None:
    """N is a small difference of large motions: the bench turns by 1e-5 rad/K, and the read-out is 1e-8 rad/K of it.

    With motions in double precision it agrees to 1e-6 of every row; those of an OP2 leave their rounding, of vectors
    whose components are others in the turned frame.
    """
    exact, rounding = zip(*(read_out_of_exact_motions(built) for built in (plate, turned)), strict=True)
    largest = np.abs(exact[0]).max(axis=1, keepdims=True)
    assert (np.abs(exact[1] - exact[0]) < 1e-6 * largest).all()
    found = [built.array("optics", "/N/A") for built in (plate, turned)]
    for n, e, bound in zip(found, exact, rounding, strict=True):
        assert (np.abs(n - e) < bound).all()
    assert (np.abs(found[1] - found[0]) < 1e-4 * largest).all()
