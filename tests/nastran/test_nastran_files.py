"""Decks and results of commercial solvers: each is read and right, or refused by name, as docs/reference says."""

from __future__ import annotations

import contextlib
import io
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from rod_model import one_load, read, rod_cards

from tedm_cli.errors import InputError
from tedm_cli.nastran.displacements import unit_load_displacements
from tedm_cli.nastran.geometry import ModelGeometry, model_geometry
from tedm_cli.nastran.loads.unit_loads import deck_unit_loads
from tedm_cli.nastran.op2.reader import open_op2
from tedm_cli.nastran.reading import read_deck
from tedm_cli.nastran.result_files import open_result_file

DOCUMENT = Path(__file__).parents[2] / "docs" / "reference" / "nastran.md"
OUTCOMES = dict(re.findall(r"^\| (\S+\.(?:bdf|op2|h5)) \| (.+) \|$", DOCUMENT.read_text(encoding="utf-8"), re.M))
SINGLE = 2e-7


def test_every_file_is_in_the_table(nastran_dir: Path) -> None:
    assert set(OUTCOMES) == {p.name for p in nastran_dir.iterdir() if p.suffix in (".bdf", ".op2", ".h5")}


@pytest.mark.parametrize("name", OUTCOMES)
def test_outcome(nastran_dir: Path, name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: Any) -> None:
    """Nothing is printed and no file is left behind, whatever the outcome."""
    monkeypatch.chdir(tmp_path)
    by_ending = {".bdf": read_unit_loads, ".op2": compare_with_pynastran, ".h5": compare_with_h5py}
    read_it = by_ending[Path(name).suffix]
    if OUTCOMES[name] == "read":
        read_it(nastran_dir / name)
    else:
        (piece,) = re.findall(r"refused: `(.+)`", OUTCOMES[name])
        with pytest.raises(InputError) as caught:
            read_it(nastran_dir / name)
        assert piece in str(caught.value)
        assert name in caught.value.where
    assert not list(tmp_path.iterdir())
    assert capfd.readouterr() == ("", "")


def read_unit_loads(path: Path) -> None:
    model = read_deck(path)
    deck_unit_loads(model, model_geometry(model, [path]), "UNIFORM")


def pynastran(path: Path) -> Any:
    from pyNastran.op2.op2 import OP2

    model = OP2(debug=None)
    model.set_results("displacements")
    with contextlib.redirect_stdout(io.StringIO()):
        model.read_op2(str(path), build_dataframe=False, skip_undefined_matrices=True)
    return model


def compare_with_pynastran(path: Path) -> None:
    with open_op2(path) as (tables, read_table):
        ours = {t.subcase: (t, read_table(t)) for t in tables}
    theirs = {int(k[0] if isinstance(k, tuple) else k): t for k, t in pynastran(path).displacements.items()}
    assert set(ours) == set(theirs)
    for subcase, (header, got) in ours.items():
        table = theirs[subcase]
        grids = table.node_gridtype[:, 1] == 1
        np.testing.assert_array_equal(got.grid_id, table.node_gridtype[grids, 0])
        np.testing.assert_array_equal(got.motion, table.data[0][grids])
        assert header.name == table.table_name.strip()
        assert " ".join(table.label.split()).startswith(header.label)


def compare_with_h5py(path: Path) -> None:
    """Numbers and ids as they are in the one table, of one subcase."""
    with h5py.File(path) as file:
        rows = file["NASTRAN/RESULT/NODAL/DISPLACEMENT"][()]
    with open_result_file(path) as (tables, read_table):
        (got,) = (read_table(t) for t in tables)
    np.testing.assert_array_equal(got.grid_id, rows["ID"])
    for column, name in enumerate(("X", "Y", "Z", "RX", "RY", "RZ")):
        np.testing.assert_array_equal(got.motion[:, column], rows[name])


def test_scalar_points_and_adaptivity(nastran_dir: Path) -> None:
    table = next(iter(pynastran(nastran_dir / "cqra00366.op2").displacements.values()))
    scalar = table.node_gridtype[table.node_gridtype[:, 1] == 2, 0]
    with open_op2(nastran_dir / "cqra00366.op2") as (tables, read_table):
        assert [t.label for t in tables] == [
            "STATIC LOAD",
            "TURN ON TEMP LOADS",
            "TURN ON DEFORM LOADS FOR 1-D ELEMENTS",
        ]
        got = read_table(tables[0])
    assert scalar.size == 20
    assert not np.isin(scalar, got.grid_id).any()


def test_temperatures_are_no_displacements(nastran_dir: Path) -> None:
    with open_op2(nastran_dir / "htrussx.op2") as (tables, _):
        assert [(t.subcase, t.label) for t in tables] == [(2, "STRESS ANALYSIS")]


def test_initial_temperature_of_laminates(nastran_dir: Path, tmp_path: Path) -> None:
    """20 K at first, 20 to 200 K in the load: steps of 0 (the clamped edge), 50, ... 180 K."""
    text = (nastran_dir / "TestStressTemp.bdf").read_text()
    thermal = re.sub(r"SUBCASE [13]\n(.*\n)+?(?=\$ Direct Text Input for this Subcase)", "", text)
    thermal = thermal.replace("SUBCASE 2\n", "SUBCASE 2\n   LABEL = EDGE\n")
    assert thermal.count("LOAD = ") == 0
    deck = tmp_path / "thermal.bdf"
    deck.write_text(thermal)
    model, geometry = read(deck)
    with pytest.raises(InputError, match=r"'EDGE'.*by 50 to 180 K"):
        deck_unit_loads(model, geometry, "UNIFORM")


# --- one structure, solved with CD = 0 and in a cylindrical frame ----------------------------------------------------


def with_elements(source: Path, folder: Path, extra: str = "") -> ModelGeometry:
    """A deck whose elements are in a lost file, with rods in their place: its grids and frames are what counts."""
    text = re.sub(r"^INCLUDE.*\n", "", source.read_text(), flags=re.M)
    text = text.replace("ENDDATA", f"{extra}{rod_cards(range(1, 26))}\nENDDATA")
    deck = folder / source.name
    deck.write_text(text)
    return read(deck)[1]


def in_basic(op2: Path, geometry: ModelGeometry) -> tuple[np.ndarray, np.ndarray]:
    load = one_load(geometry)
    ((_, translation, rotation),) = unit_load_displacements([op2], [load], geometry, {"ALL": 1})
    return translation, rotation


def relative(found: np.ndarray, wanted: np.ndarray) -> float:
    return float(np.abs(found - wanted).max() / np.abs(wanted).max())


def lengths(v: np.ndarray) -> np.ndarray:
    return np.asarray(np.linalg.norm(v, axis=1))


@pytest.mark.filterwarnings("ignore:bad fields:UserWarning")
def test_the_results_say_which_deck_is_theirs(nastran_dir: Path) -> None:
    """The OP2 files hold their own grids and loads: CD = 12 in one, 0 in the other, and one and the same force."""
    from pyNastran.op2.op2_geom import OP2Geom

    frames, forces = {}, {}
    for name in ("static_solid_shell_bar", "static_solid_shell_bar_radial"):
        model = OP2Geom(debug=None)
        with contextlib.redirect_stdout(io.StringIO()):
            model.read_op2(str(nastran_dir / f"{name}.op2"), build_dataframe=False)
        frames[name] = {int(g.Cd()) for g in model.nodes.values()}
        forces[name] = [(f.node, f.Cid(), f.mag, tuple(f.xyz)) for f in model.loads[10000]]
    assert list(frames.values()) == [{0}, {12}]
    assert len(set(map(str, forces.values()))) == 1


def test_cylindrical_frame_against_the_twin_in_the_basic_frame(nastran_dir: Path, tmp_path: Path) -> None:
    plain = with_elements(nastran_dir / "static_solid_shell_bar.bdf", tmp_path)
    radial = with_elements(nastran_dir / "static_solid_shell_bar_radial.bdf", tmp_path)
    wanted = in_basic(nastran_dir / "static_solid_shell_bar.op2", plain)
    # Grid 7 is on the axis but for the rounding of the turned frame, and the solver took its angle from that: refused.
    results = nastran_dir / "static_solid_shell_bar_radial.op2"
    with pytest.raises(InputError, match=r"1 grids .* axis .*: 7 \(CD 12\)"):
        in_basic(results, radial)
    # It was -90 degrees, -y and x of the frame: said so by a frame of its own, all grids agree.
    _, origin, (x, y, z) = radial.frames[12]
    known = replace(
        radial,
        displacement_frame=np.where(radial.grid_id == 7, 99, radial.displacement_frame),
        frames={**radial.frames, 99: ("R", origin, np.array([-y, x, z]))},
    )
    found = in_basic(results, known)
    assert relative(found[0], wanted[0]) < SINGLE
    assert relative(found[1], wanted[1]) < SINGLE
    # Without the turn the twins differ by as much as they move.
    unturned = in_basic(nastran_dir / "static_solid_shell_bar_radial.op2", plain)
    assert relative(unturned[0], wanted[0]) > 0.5


def test_the_deck_of_similar_name_is_not_theirs(nastran_dir: Path, tmp_path: Path) -> None:
    """With the frame of the other deck (mended: its CORD2C lacks its continuation) only lengths agree."""
    other = "static_solid_shell_bar_global_radial_cd.bdf"
    with pytest.raises(InputError, match="CORD2C 1"):
        with_elements(nastran_dir / other, tmp_path)
    mended = tmp_path / other
    text = (nastran_dir / other).read_text().replace(" 0.,0.,1., 0.,1.,0.", " 0.,0.,1.\n, 0.,1.,0.")
    mended.write_text(text)
    (tmp_path / "mended").mkdir()
    wrong = with_elements(mended, tmp_path / "mended")
    assert set(wrong.displacement_frame) == {1}
    plain = with_elements(nastran_dir / "static_solid_shell_bar.bdf", tmp_path)
    wanted, _ = in_basic(nastran_dir / "static_solid_shell_bar.op2", plain)
    found, _ = in_basic(nastran_dir / "static_solid_shell_bar_radial.op2", wrong)
    assert relative(lengths(found), lengths(wanted)) < SINGLE
    assert relative(found, wanted) > 0.5


def test_pynastran_turns_cylindrical_frames_wrongly(nastran_dir: Path, tmp_path: Path) -> None:
    """Why the rotation is ours. When this fails pyNastran has mended it."""
    twin = pynastran(nastran_dir / "static_solid_shell_bar.op2").displacements[1].data[0, :, :3]
    results = pynastran(nastran_dir / "static_solid_shell_bar_radial.op2")
    radial = with_elements(nastran_dir / "static_solid_shell_bar_radial.bdf", tmp_path)
    model = read_deck(radial.files[0])
    frames, places, coordinates, ids = model.get_displacement_index_xyz_cp_cd()
    x = model.transform_xyzcp_to_xyz_cid(coordinates, ids[:, 0], places, 0)
    np.testing.assert_allclose(x, radial.position_m, rtol=0, atol=1e-15)
    with contextlib.redirect_stdout(io.StringIO()):
        results.transform_displacements_to_global(frames, model.coords, xyz_cid0=x)
    off_axis = radial.grid_id != 7
    turned = results.displacements[1].data[0, :, :3]
    assert relative(turned[off_axis], twin[off_axis]) > 0.1
