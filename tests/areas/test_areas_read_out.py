"""Read-outs of a bench on four struts of one bar: an area of elements against fine meshes, and an area of grids."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pytest
from strut_model import CORNERS, LENGTH, LOWER, UPPER, deck, define, plate_grid, project, strut_element

from tedm_cli.arrays import FloatArray
from tedm_cli.config.project import Project, load_project
from tedm_cli.errors import InputError
from tedm_cli.progress import silent
from tedm_cli.stages.model.deck import write_deck
from tedm_cli.stages.model.distortion import build_distortion
from tedm_cli.stages.model.ingest import ingest
from tedm_cli.stages.model.solve import solve
from tedm_cli.stages.optics.build import build_optics

# A Michelson on grids of the upper plate; the test mass stands free.
MICHELSON = f"""
title = "Michelson on struts"
wavelength_m = 1.064e-6
read_out = ["x", "eta", "phi"]
frame = {{ origin_m = [0.0, 0.0, 0.0], axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] }}
sets = {{ A = ["PD"] }}

[[element]]
name = "TM1"
kind = "test_mass"
ref_m = [0.13, 0.0, {LENGTH}]
normal = [-1.0, 0.0, 0.0]
front_offset_m = 0.023

[[element]]
name = "FI"
kind = "injector"
grid = {plate_grid(1, 4, 1)}
ref_m = [0.0, -0.1, {LENGTH}]
normal = [0.0, 1.0, 0.0]

[[element]]
name = "BS"
kind = "beamsplitter"
grid = {plate_grid(1, 4, 3)}
ref_m = [0.0, 0.0, {LENGTH}]
normal = [0.7071067811865476, -0.7071067811865476, 0.0]
thickness_m = 0.005
index = 1.45

[[element]]
name = "M"
kind = "mirror"
grid = {plate_grid(1, 4, 5)}
ref_m = [0.0, 0.1, {LENGTH}]
normal = [0.0, -1.0, 0.0]

[[element]]
name = "PD"
kind = "photodiode"
grid = {plate_grid(1, 2, 3)}
ref_m = [-0.1, 0.0, {LENGTH}]
normal = [1.0, 0.0, 0.0]
local_y = [0.0, 0.0, 1.0]

[[path]]
photodiode = "PD"
beam = "meas"
steps = ["FI", "BS:R", "TM1:R", "BS:T", "PD"]

[[path]]
photodiode = "PD"
beam = "ref"
steps = ["FI", "BS:T", "M:R", "BS:R", "PD"]
"""


def built(folder: Path, parts: int, tables: str, layout: str = MICHELSON) -> Project:
    """The chain to optics.h5, by the stages of the commands."""
    project(folder, deck(parts), tables)
    (folder / "optics.toml").write_text(layout)
    here = load_project(folder / "tedm.toml", folder / "build")
    write_deck(here, None)
    solve(here, None, silent)
    ingest(here, None, silent)
    build_distortion(here, None, silent)
    build_optics(here, None)
    return here


def read_outs(folder: Path, parts: int, tables: str) -> dict[str, FloatArray]:
    """N of every area, x (m/K) and η (rad/K) of the free test mass."""
    with h5py.File(built(folder, parts, tables).build_dir / "optics.h5") as file:
        n = file["N/A"][()]
        names = file["area/name"].asstr()[()]
        return dict(zip(names.tolist(), n.T[:, :2], strict=True))  # the yaw of the plates is held: no φ


def test_read_outs_of_a_short_strut(tmp_path: Path) -> None:
    """With ever more bars N of areas of grids goes to that of the area of elements with one bar, as 1/n."""
    others = define("OTHERS", element='"5100:5399"', carrier='"elements"')
    strut = define("STRUT", element=strut_element(0), carrier='"elements"')
    wanted = read_outs(tmp_path / "elements", 1, strut + others + LOWER + UPPER)["STRUT"]
    gaps = []
    for parts in (4, 16):
        fine = define("STRUT", element='"5000:5099"') + define("OTHERS", property=2)
        found = read_outs(tmp_path / f"{parts}", parts, LOWER + UPPER + fine)["STRUT"]
        gaps.append(np.abs(found - wanted) / np.abs(wanted))
    assert gaps[0] == pytest.approx(1 / 4, rel=1e-4)
    assert gaps[1] == pytest.approx(1 / 16, rel=1e-4)
    coarse = define("STRUT", element=strut_element(0), box="{ z_m = [0.05, inf] }")
    found = read_outs(tmp_path / "grids", 1, coarse + LOWER + UPPER)["STRUT"]
    print("N of an area of grids over that of an area of elements, x, eta:", found / wanted)
    assert np.abs(found / wanted - 1.0).max() > 0.3  # η has two thirds of what it should have


def test_a_plate_has_the_temperature_of_the_area_of_its_grid(tmp_path: Path) -> None:
    """Of the beam splitter, without a word; where its grid is an end of a strut that is warmed too, of neither.

    The beam of the mirror passes it three times, that of the test mass once; either is at 45 degrees.
    """
    warm = MICHELSON.replace("index = 1.45", "index = 1.45\ndn_dT_1_K = 8.3e-6")
    struts = define("STRUT", element='"5000:5399"', carrier='"elements"')
    here = built(tmp_path, 1, struts + LOWER + UPPER, warm)
    with h5py.File(here.build_dir / "optics.h5") as file:
        names = file["area/name"].asstr()[()].tolist()
        found = dict(zip(names, file["N_plates/A"][()].T, strict=True))
    assert set(names) == {"STRUT", "LOWER", "UPPER"}
    assert np.abs(found["UPPER"][0]) == pytest.approx(0.005 * 1.45 / np.sqrt(1.45**2 - 0.5) * 8.3e-6, rel=1e-9)
    assert not found["STRUT"].any()
    assert not found["LOWER"].any()
    layout = tmp_path / "optics.toml"
    layout.write_text(
        warm.replace(f"grid = {plate_grid(1, 4, 3)}\n", f"grid = {plate_grid(1, *CORNERS[0])}\nlever_ok = true\n")
    )
    build_distortion(here, None, silent)
    with pytest.raises(InputError, match=r"its grid \d+ is in several thermal areas \(STRUT, UPPER\)") as caught:
        build_optics(here, None)
    assert caught.value.where == f"{layout}: element BS"
    layout.write_text(layout.read_text().replace("dn_dT_1_K", 'area = "LOWER"\ndn_dT_1_K'))
    build_optics(here, None)
    with h5py.File(here.build_dir / "optics.h5") as file:
        assert not file["N_plates/A"][()].T[names.index("UPPER")].any()
        assert file["N_plates/A"][()].T[names.index("LOWER")].any()
