"""The masses against others: pyNastran's on a sample, a solver's grid point weight table; test masses in the mesh."""

from __future__ import annotations

import dataclasses
import re
import struct
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from mass_decks import deck, read
from op2_records import HEADER, join, records

from tedm_cli.config.base import validate
from tedm_cli.config.model.file import ModelConfig
from tedm_cli.deck_units import DeckUnits
from tedm_cli.errors import ConfigError, InputError, PhysicsError
from tedm_cli.gravity.mass_properties import MassProperties
from tedm_cli.nastran.geometry import ModelGeometry
from tedm_cli.nastran.masses.audit import _holds, check_sample, weight_table
from tedm_cli.nastran.op2.reader import open_op2
from tedm_cli.nastran.reading import read_deck
from tedm_cli.stages.model.masses import (
    check_grids_outside,
    check_weight_tables,
    properties_of,
    without_test_masses,
)

MODEL = """CHEXA,1,1,1,2,3,4,5,6,
,7,8
CQUAD4,2,2,1,2,6,5
CBAR,4,4,1,7,0.,1.,0.
CONM2,11,7,,200.,.1,.2,.3
PSOLID,1,1
PSHELL,2,1,.01,1,,1,,2.
PBAR,4,1,1.-3,1.,1.,1.,.5
NSM1,7,PSHELL,50.,2"""


@pytest.fixture
def geometry(tmp_path: Path) -> ModelGeometry:
    return read(tmp_path, deck(MODEL, control="NSM = 7"))


def rigid_matrix(p: MassProperties, about: np.ndarray) -> np.ndarray:
    """6 x 6 mass matrix of rigid motions about a place."""
    away = p.centre_m - about
    arm = np.cross(np.eye(3), away).T
    out = np.zeros((6, 6))
    out[:3, :3], out[:3, 3:], out[3:, :3] = p.mass_kg * np.eye(3), p.mass_kg * arm, p.mass_kg * arm.T
    out[3:, 3:] = p.inertia_kg_m2 + p.mass_kg * (away @ away * np.eye(3) - np.outer(away, away))  # Huygens, Steiner
    return out


def write_table(path: Path, matrix: np.ndarray, reference: int = 0) -> Path:
    from pyNastran.op2.op2 import OP2
    from pyNastran.op2.result_objects.grid_point_weight import make_grid_point_weight

    results = OP2(debug=None)
    results.date = (1, 1, 2000)
    results.set_as_msc()
    results.grid_point_weight[""] = make_grid_point_weight(reference, matrix)
    results.write_op2(str(path), post=-1, nastran_format="msc")
    return path


@pytest.mark.parametrize("lumped", [True, False])
@pytest.mark.parametrize("reference", [0, 7])
def test_table_of_the_same_model_agrees(geometry: ModelGeometry, tmp_path: Path, lumped: bool, reference: int) -> None:
    """Lumped to the grids and spread over the elements, about the origin and about a grid."""
    p = properties_of(geometry, lumped=lumped)
    about = geometry.position_m[6] if reference else np.zeros(3)
    path = write_table(tmp_path / "weight.op2", rigid_matrix(p, about), reference)
    assert len(check_weight_tables([path], geometry, 1.0)) == 1
    table = weight_table(path, lambda grid: about)
    assert table is not None
    np.testing.assert_allclose(table.centre, p.centre_m, rtol=0, atol=1e-6)
    np.testing.assert_allclose(table.inertia, p.inertia_kg_m2, rtol=0, atol=1e-5 * p.inertia_kg_m2.max())


def heavier(p: MassProperties) -> MassProperties:
    return dataclasses.replace(p, mass_kg=1.002 * p.mass_kg)


def shifted(p: MassProperties) -> MassProperties:
    return dataclasses.replace(p, centre_m=np.add(p.centre_m, [0.0, 0.02, 0.0]))


def stiffer(p: MassProperties) -> MassProperties:
    return dataclasses.replace(p, inertia_kg_m2=p.inertia_kg_m2 + np.diag([0.0, 0.0, 0.3 * p.inertia_kg_m2[2, 2]]))


@pytest.mark.parametrize(
    ("change", "fact"),
    [(heavier, r"kg \(x, y, z\), the deck"), (shifted, "centre of gravity at"), (stiffer, "moments of inertia")],
)
def test_table_of_another_model_is_refused(
    geometry: ModelGeometry, tmp_path: Path, change: Callable[[MassProperties], MassProperties], fact: str
) -> None:
    other = change(properties_of(geometry, lumped=True))
    path = write_table(tmp_path / "weight.op2", rigid_matrix(other, np.zeros(3)))
    with pytest.raises(InputError, match=fact):
        check_weight_tables([path], geometry, 1.0)


def test_table_before_wtmass(geometry: ModelGeometry, tmp_path: Path) -> None:
    p = properties_of(geometry)
    path = write_table(tmp_path / "weight.op2", 100.0 * rigid_matrix(p, np.zeros(3)))
    assert len(check_weight_tables([path], geometry, 0.01)) == 1


def test_table_in_the_units_of_its_deck(geometry: ModelGeometry, tmp_path: Path) -> None:
    """In millimetres and tonnes: blocks of mass, static moment and inertia are 1e-3, 1 and 1e3 of those in SI."""
    matrix = rigid_matrix(properties_of(geometry), np.zeros(3))
    for rows, columns, factor in ((slice(3), slice(3), 1e-3), (slice(3, 6), slice(3, 6), 1e3)):
        matrix[rows, columns] *= factor
    path = write_table(tmp_path / "weight.op2", matrix)
    of_deck = dataclasses.replace(geometry, units=DeckUnits(1e-3, 1e3))
    assert len(check_weight_tables([path], of_deck, 1.0)) == 1
    with pytest.raises(InputError, match="its grid point weight table has"):
        check_weight_tables([path], geometry, 1.0)


def test_table_of_an_independent_solver(mini_ltp_dir: Path, tmp_path: Path) -> None:
    """Its lumped masses are ours, to the single precision of the OP2; a deck that lost a mass is found out."""
    text = (mini_ltp_dir / "mini_ltp.bdf").read_text()
    g = read(tmp_path, text)
    table = check_weight_tables([mini_ltp_dir / "mini_ltp.op2"], g, 1.0)[0]
    p = properties_of(g, lumped=True)
    np.testing.assert_allclose(table.mass, p.mass_kg, rtol=1e-7)
    np.testing.assert_allclose(table.centre, p.centre_m, rtol=0, atol=1e-9)
    np.testing.assert_allclose(table.inertia, p.inertia_kg_m2, rtol=0, atol=1e-7 * p.inertia_kg_m2.max())
    lines = [line for line in text.splitlines() if not line.startswith("CONM2")]
    with pytest.raises(InputError, match=r"kg \(x, y, z\), the deck"):
        check_weight_tables([mini_ltp_dir / "mini_ltp.op2"], read(tmp_path, "\n".join(lines)), 1.0)


def test_table_whose_mass_differs_by_direction(nastran_dir: Path) -> None:
    """A model of all cards, solved by MSC Nastran, has scalar masses in single directions."""
    table = weight_table(nastran_dir / "cqra00366.op2", lambda grid: np.zeros(3))
    assert table is not None
    np.testing.assert_allclose(table.mass, [204.6378, 203.5378, 205.7378], rtol=1e-6)


@pytest.mark.parametrize(("table", "subcase"), [("OGPWG", 0), ("OUGV1", 0), ("OUGV1", 7)])
def test_damage_is_said_to_be_where_it_is(mini_ltp_dir: Path, tmp_path: Path, table: str, subcase: int) -> None:
    """A wrong marker before a record of a file with both tables, whoever reads it: its table, subcase and byte."""
    payloads = records((mini_ltp_dir / "mini_ltp.op2").read_bytes())
    named = next(i for i, p in enumerate(payloads) if p.strip() == table.encode())
    headers = [i for i, p in enumerate(payloads) if len(p) == HEADER and i > named]
    at = headers[max(subcase - 1, 0)] + (3 if subcase else -1)  # before the rows, or before the header
    payloads[at] = struct.pack("<i", 12345)
    path = tmp_path / "damaged.op2"
    path.write_bytes(join(payloads))
    byte = len(join(payloads[:at]))
    for read_it in (lambda: weight_table(path, lambda grid: np.zeros(3)), lambda: open_op2(path).__enter__()):
        with pytest.raises(InputError) as caught:
            read_it()
        found = re.search(r"bytes ([\d,]+) and ([\d,]+): .* table (\w+)(?: in subcase (\d+))?$", caught.value.fact)
        assert found, caught.value.fact
        assert (found[3], int(found[4] or 0)) == (table, subcase)
        first, last = (int(found[k].replace(",", "")) for k in (1, 2))
        assert first - 200 <= byte <= last
        assert last - first < 100_000


def test_results_without_a_table(geometry: ModelGeometry, tmp_path: Path) -> None:
    path = tmp_path / "none.op2"
    path.write_bytes(b"\x04\0\0\0 no such table")
    assert check_weight_tables([path], geometry, 1.0) == []


def test_sample_agrees_and_finds_a_wrong_mass(geometry: ModelGeometry) -> None:
    model = read_deck(geometry.files[0])
    check = check_sample(model, geometry)
    assert check.elements == 3
    assert check.largest < 1e-12
    wrong = dataclasses.replace(geometry.elements, mass_kg=geometry.elements.mass_kg * [1.0, 1.3, 1.0])
    with pytest.raises(InputError, match=r"1 CQUAD4 of property 2 have .* pyNastran finds"):
        check_sample(model, dataclasses.replace(geometry, elements=wrong))


def config(parts: str, position: tuple[float, float, float] = (1.0, 0.5, 1.5)) -> ModelConfig:
    import tomllib

    text = f"""[model]
[areas]
rule = [{{ match = "*", group = "all", shield = "inside" }}]
[[test_mass]]
name = "TM1"
position_m = {list(position)}
side_m = 0.046
mass_kg = 1.96
{parts}
"""
    found = validate(ModelConfig, tomllib.loads(text), where="model.toml")
    assert not found.make_test_masses(Path())
    return found


@pytest.mark.parametrize(
    ("parts", "gone"),
    [
        ("elements = [1, 11]", 6200.0),
        ("properties = [2]", 6 * 62.0),
        ("grids = [1, 2, 5, 6]", 6 * 62.0),
        ("grids = [7]", 200.0),
        ("properties = [1]\ngrids = [7]", 6200.0),
    ],
)
def test_what_stands_for_a_test_mass_is_left_out(geometry: ModelGeometry, parts: str, gone: float) -> None:
    whole = properties_of(geometry).mass_kg
    table = "[test_mass.model_parts]\n" + parts
    kept, removed = without_test_masses(geometry, config(table), Path("model.toml"))
    assert removed == pytest.approx([gone], rel=1e-9)
    assert properties_of(kept).mass_kg == pytest.approx(whole - gone, rel=1e-9)
    assert kept.total_kg == pytest.approx(whole - gone, rel=1e-9)


def test_parts_that_do_not_exist(geometry: ModelGeometry) -> None:
    table = "[test_mass.model_parts]\nelements = [1, 77]\ngrids = [88]"
    with pytest.raises(ConfigError) as caught:
        without_test_masses(geometry, config(table), Path("model.toml"))
    assert [path for path, _ in caught.value.problems] == [
        "test_mass[0].model_parts.elements",
        "test_mass[0].model_parts.grids",
    ]


def test_grids_with_mass_inside_a_test_mass(geometry: ModelGeometry) -> None:
    near = config("", (2.0, 1.0, 3.01))
    with pytest.raises(PhysicsError, match="1 grids with mass are inside test mass 'TM1': 7"):
        check_grids_outside(near.test_masses(), geometry)
    parts = config("[test_mass.model_parts]\nproperties = [1, 4]\ngrids = [7]", (2.0, 1.0, 3.01))
    check_grids_outside(parts.test_masses(), without_test_masses(geometry, parts, Path("model.toml"))[0])


def test_a_name_is_found_wherever_pieces_of_a_file_end(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """At every place of files of up to 50 bytes, which are read 16 at a time; and not where it is not."""
    monkeypatch.setattr("tedm_cli.nastran.masses.audit._PIECE", 16)
    for size in range(50):
        for at in (None, *range(size - 3)):
            data = bytearray(b"OGP" * 17)[:size]
            if at is not None:
                data[at : at + 4] = b"OGPW"
            (tmp_path / "f").write_bytes(data)
            assert _holds(tmp_path / "f", b"OGPW") == (at is not None)
