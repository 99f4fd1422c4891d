"""What mutated inputs brought to light, one test to a kind of fault."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace as Made

import h5py
import numpy as np
import pytest
from fuzz_binary import join, split
from fuzz_model import Case

from tedm_cli.cli.printing.dynamics import dynamics_lines
from tedm_cli.config.base import validate
from tedm_cli.config.model.file import load_model
from tedm_cli.config.requirements import RequirementTable
from tedm_cli.contracts import DISTORTION
from tedm_cli.distortion import ROUNDING, superposition_excess
from tedm_cli.errors import ConfigError, InputError, PhysicsError
from tedm_cli.files.seal import seal
from tedm_cli.files.store import open_checked


def replace(path: Path, old: str, new: str) -> None:
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))


@pytest.mark.parametrize(
    ("old", "new", "fact"),
    [
        ("\n,.9,.3,.2\nCHEXA", "\nCHEXA", "CORD2S 30: lacks its third point"),
        ("\n,.9,.3,.2\nCHEXA", "\n,,,\nCHEXA", "CORD2S 30: lacks its third point"),
        ("\n,.9,.3,.2\nCHEXA", "\n,.9,.3,.2\n,.9,.3,.2\nCHEXA", "CORD2S 30: has more fields than three points"),
        (".5\n,.9,.3,.2\nCHEXA", ".5,.9,.3,.2\nCHEXA", "CORD2S 30: has 12 fields in a line, which holds 10"),
        ("GRID,1,,0.0", "GRID,1,,nan", "GRID 1: nan is no number"),
        ("GRID,1,,0.0", "GRID,1,,-Inf", "GRID 1: -Inf is no number"),
        ("GRID,1,,0.0", "GRID,1,,1.+400", "GRID 1: 1.+400 is no number"),
        (
            "GRID,1,,0.0,0.0,0.0,",
            "GRID,1,,0.0,0.0,0.0,-1",
            "1 GRID with CD = -1, which hold a pressure and do not move: 1\n",
        ),
        ("ENDDATA", "SPOINT,500,THRU,99999999\nENDDATA", "500 THRU 99999999 names more ids"),
        ("123     10      11      12", "123     00      11      12", "RBE2 52 has a zero or a blank among its grids"),
        ("ENDDATA", "INCLUDE ''\nENDDATA", "INCLUDE names no file"),
        ("ENDDATA", "INCLUDE '/'\nENDDATA", r":\d+: INCLUDE of /, which is a folder, not a regular file"),
        ("ENDDATA", "         ENDDATA", "has no ENDDATA"),
        ("TEMPERATURE(LOAD)", "TEMPERATURE(LOA D)", r"TEMPERATURE\(LOA D\) is not known here"),
        ("ENDDATA", "INCLUDE '" + 300 * "x" + "'\nENDDATA", "INCLUDE names no file"),
    ],
)
def test_what_pynastran_passes_over_in_a_deck(case: Case, old: str, new: str, fact: str) -> None:
    replace(case.deck, old, new)
    with pytest.raises(InputError, match=f"unit_loads.bdf.*{fact}"):
        case.run()


def test_a_message_has_no_control_characters() -> None:
    assert str(InputError("label 'A\x1b[2J\x00'", where="f.op2")) == "f.op2: label 'A?[2J?'"


def test_lengths_of_records_are_checked_before_anything_is_read(case: Case) -> None:
    data = bytearray(case.op2.read_bytes())
    data[12:16] = (12).to_bytes(4, "little")  # of the second record, the date
    assert len(split(case.op2.read_bytes())[1]) == 12
    data[12:16] = (2**31 - 1).to_bytes(4, "little")
    case.op2.write_bytes(data)
    with pytest.raises(InputError, match=r"record at byte 12 is 2,147,483,647 bytes long, the file has [\d,]+\n"):
        case.run()
    data[12:16] = (-8).to_bytes(4, "little", signed=True)
    case.op2.write_bytes(data)
    with pytest.raises(InputError, match="byte 12 has a length of -8 bytes"):
        case.run()


def edit(case: Case, change: Callable[[list[bytes]], None]) -> None:
    payloads = split(case.op2.read_bytes())
    change(payloads)
    case.op2.write_bytes(join(payloads))


def test_labels_that_have_changed_places(case: Case) -> None:
    """They leave the sum of the areas as it is."""

    def swap(payloads: list[bytes]) -> None:
        a, b = [i for i, p in enumerate(payloads) if len(p) == 584][:2]
        x, y = payloads[a], payloads[b]
        payloads[a], payloads[b] = x[:456] + y[456:], y[:456] + x[456:]

    edit(case, swap)
    with pytest.raises(InputError, match="subcase 1 is labelled 'WAIST', and 'ROOT' in the deck"):
        case.run()
    replace(
        case.folder / "model.toml", "[areas]", "[model.subcases]\nROOT = 1\nWAIST = 2\nTIP = 3\nUNIFORM = 4\n\n[areas]"
    )
    case.run()


def test_a_table_with_two_names(case: Case) -> None:
    def rename(payloads: list[bytes]) -> None:
        at = next(i for i, p in enumerate(payloads) if p.startswith(b"OUG1") and len(p) == 28)
        payloads[at] = b"BOUGV1  " + payloads[at][8:]

    edit(case, rename)
    with pytest.raises(InputError, match="a table is named OUGV1 and BOUGV1"):
        case.run()


@pytest.mark.parametrize("key", ["bdf", "areas_csv", "deck", "op2"])
def test_a_file_without_a_name_is_refused_where_it_is_named(case: Case, key: str) -> None:
    """It would be the folder of the configuration."""
    model = case.folder / "model.toml"
    text, count = re.subn(f'(?m)^({key} = \\[?)".*?"', r'\1""', model.read_text())
    assert count == 1
    model.write_text(text)
    with pytest.raises(ConfigError, match=rf"model.toml: model.{key}(\[0\])?: .*at least 1 character"):
        load_model(model)
    table = {"name": "a", "table": "", "quantity": "acceleration", "outputs": ["TM1_a_x"]}
    with pytest.raises(ConfigError, match=r"cases.toml: table: .*at least 1 character"):
        validate(RequirementTable, table, where="cases.toml")


def test_a_loop_that_crosses_nowhere_has_no_crossover() -> None:
    """Strong stiffness may leave a loop without a frequency of gain 1: words, and no number that is none."""
    nowhere = Made(
        loop="x12", crossover_hz=np.nan, phase_deg=np.inf, gain_db=51.2, reduction_db=np.inf, peak_sensitivity=1.0
    )
    body = Made(mass_kg=430.0, centre_of_mass_m=(0.0, 0.0, 0.0))
    loop = Made(plant=Made(spacecraft=body), names=("TM1", "TM2"), config=Made(stiffness=Made(words=lambda: "none")))
    stability = Made(poles=[-1.0], largest_real_part=-1.0, margins=[nowhere])
    lines = dynamics_lines(Made(loop=loop, stability=stability, path=Path("dynamics.h5")))  # type: ignore[arg-type]
    (row,) = [line.split() for line in lines if line.startswith("x12")]
    assert row == ["x12", "none", "any", "+51.2", "any", "1.00"]


ROWS = 14  # two elements, no rigid element on 1, 5 and 9


@pytest.mark.parametrize(("column", "what"), [(2, "translation"), (4, "translation"), (5, "rotation"), (7, "rotation")])
@pytest.mark.parametrize("subcase", range(4))
def test_one_wrong_number_is_found(case: Case, subcase: int, column: int, what: str) -> None:
    """A change by 1e-5 of the largest motion under any load, of a grid no rigid element ties; rotations of optics."""
    columns = slice(2, 5) if what == "translation" else slice(5, 8)

    def spoil(payloads: list[bytes]) -> None:
        headers = [i for i, p in enumerate(payloads) if len(p) == 584]
        places = [next(j for j in range(i + 1, len(payloads)) if len(payloads[j]) > 4) for i in headers]
        tables = [np.frombuffer(payloads[j], "<f4").reshape(ROWS, 8) for j in places]
        rows, at = tables[subcase].copy(), places[subcase]
        rows[8 if what == "translation" else 13, column] += 1e-5 * max(np.abs(t[:, columns]).max() for t in tables)
        payloads[at] = rows.tobytes()

    edit(case, spoil)
    with pytest.raises(PhysicsError, match=f"the {what} of grid (9|900002) is off by .* times what single precision"):
        case.run()


def test_what_single_precision_explains_is_no_error() -> None:
    """Sums of numbers rounded to single precision, of all sizes, stay within a tenth; a wrong number does not."""
    random = np.random.default_rng(3)
    for k in (2, 20, 200):
        loads = random.normal(size=(k, 500, 3)) * 10.0 ** random.uniform(-9, -4, size=(1, 500, 1))
        single = loads.astype(np.float32).astype(float)
        uniform = loads.sum(axis=0).astype(np.float32).astype(float)
        size = np.linalg.norm(single, axis=2).sum(axis=0) + np.linalg.norm(uniform, axis=1)
        gap = single.sum(axis=0) - uniform
        assert superposition_excess(gap, size).max() < 0.1
        gap[7, 1] += 21 * ROUNDING * size.max()
        assert superposition_excess(gap, size).argmax() == 7
        assert superposition_excess(gap, size).max() > 1.0


@pytest.mark.parametrize("path", ["/check/max_translation", "/D_opt/rotation", "/grid/id", "/area/group"])
def test_a_flipped_bit_between_stages_is_found(case: Case, path: str) -> None:
    with h5py.File(case.distortion) as file:
        chunk = file[path].id.get_chunk_info(0)
    data = bytearray(case.distortion.read_bytes())
    data[chunk.byte_offset + chunk.size // 2] ^= 4
    case.distortion.write_bytes(data)
    damaged = pytest.raises(InputError, match=r"distortion.h5: is damaged: its SHA-256 is not")
    with damaged, open_checked(case.distortion, DISTORTION):
        pass
    seal(case.distortion)  # every array has checksums of its own
    damaged = pytest.raises(InputError, match=f"distortion.h5: {path}: cannot be read, the file is damaged")
    with damaged, open_checked(case.distortion, DISTORTION) as reader:
        reader.strings(path) if path == "/area/group" else reader.array(path)
