"""The seal and the checksums of files between the stages: what is damaged is found before HDF5 sees it."""

from __future__ import annotations

import hashlib
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import h5py
import pytest
import xarray
from border_tools import STAGES, Project, replace, tedm, untouched

from tedm_cli.contracts import DISTORTION, UNIT_LOADS
from tedm_cli.errors import InputError
from tedm_cli.files import seal
from tedm_cli.files.store import open_checked

READER = {
    "unit_loads.h5": "build-distortion",
    "distortion.h5": "build-optics",
    "sensitivity.h5": "run-case",
    "optics.h5": "run-case",
}
FILES = sorted(STAGES.values())


@pytest.mark.parametrize("name", FILES)
def test_last_line_is_the_sum_of_what_is_before(chain: Project, name: str) -> None:
    data = (chain.build / name).read_bytes()
    body, line = data[:-78], data[-78:]
    assert line == f"\ntedm sha256 {hashlib.sha256(body).hexdigest()}\n".encode()
    assert seal.sha256_of(chain.build / name) == hashlib.sha256(data).hexdigest()


@pytest.mark.parametrize(
    ("file", "old", "new"),
    [
        ("unit_loads.h5", b"CHEXA", b"CHEXI"),  # would be a lump
        ("sensitivity.h5", b"struts", b"strqts"),  # would leave a case
        ("optics.h5", b"inside", b"insidd"),
        ("distortion.h5", b"tedm build-distortion", b"tedm build-distortioo"),  # an attribute
    ],
)
def test_one_changed_letter_is_found(small: Project, file: str, old: bytes, new: bytes) -> None:
    path = small.build / file
    data = path.read_bytes()
    assert old in data
    path.write_bytes(data.replace(old, new, 1))
    with untouched(small.folder):
        small.stage(READER[file]).refused(4, f"{file}: is damaged: its SHA-256 is not", hint="make it with `tedm ")
    assert f"{file} (unknown): stale or damaged" in tedm("check", "-d", small.build).out


def test_a_lost_end_of_the_seal_is_no_seal(small: Project) -> None:
    path = small.build / "optics.h5"
    data = path.read_bytes()
    for lost, fact in ((1, "no seal"), (78, "no seal"), (79, "no seal")):
        path.write_bytes(data[:-lost])
        small.stage("run-case").refused(4, f"optics.h5: carries {fact}", hint="make it with `tedm build-optics`")
    path.write_bytes(data[:-10] + b"0" * 10)
    small.stage("run-case").refused(4, "optics.h5: is damaged")
    path.write_bytes(b"\0" * 8 + data[8:])
    small.stage("run-case").refused(4, "optics.h5: is no HDF5 file")


def test_what_another_program_changed_needs_a_new_seal(small: Project) -> None:
    path = small.build / "optics.h5"
    with h5py.File(path, "r+") as file:
        file.attrs["reviewed_by"] = "a colleague"
    small.stage("run-case").refused(4, "optics.h5: carries no seal", hint="python -m tedm_cli.files.seal")
    done = subprocess.run([sys.executable, "-m", "tedm_cli.files.seal", str(path)], capture_output=True, check=False)
    assert done.returncode == 0, done.stderr
    small.stage("run-case").ok()
    again = path.read_bytes()
    seal.seal(path)
    assert path.read_bytes() == again
    missing = [sys.executable, "-m", "tedm_cli.files.seal", str(small.build / "none.h5")]
    told = subprocess.run(missing, capture_output=True, check=False, text=True)
    assert (told.returncode, told.stderr.count("\n"), "none.h5: cannot be sealed" in told.stderr) == (1, 1, True)


def test_a_file_is_read_once_and_again_when_it_has_changed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "file"
    path.write_bytes(b"a" * 3_000_000)
    read: list[int] = []
    whole = seal._read

    def counted(*a: Any) -> Any:
        read.append(1)
        return whole(*a)

    monkeypatch.setattr(seal, "_read", counted)
    monkeypatch.setattr(seal, "_SAME_TICK", 0)
    assert seal.sha256_of(path) == seal.sha256_of(path) == hashlib.sha256(b"a" * 3_000_000).hexdigest()
    assert len(read) == 1
    path.write_bytes(b"b" * 3_000_001)
    assert seal.sha256_of(path) == hashlib.sha256(b"b" * 3_000_001).hexdigest()


def test_a_file_that_changes_under_the_reader(small: Project, monkeypatch: pytest.MonkeyPatch) -> None:
    path = small.build / "unit_loads.h5"
    opened = h5py.File

    def late(*args: object, **options: object) -> h5py.File:
        file = opened(*args, **options)
        path.write_bytes(path.read_bytes())
        return file

    monkeypatch.setattr("tedm_cli.files.store.h5py.File", late)
    with pytest.raises(InputError, match="was changed while it was read"), open_checked(path, UNIT_LOADS):
        pass


@pytest.mark.parametrize("times", [1, 3, 1000])
def test_of_a_file_that_is_replaced_under_the_reader_the_new_one_is_read(
    chain: Project, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, times: int
) -> None:
    """Another run of the command that makes it may end at any moment, with a whole file."""
    path, other = tmp_path / "distortion.h5", tmp_path / "other.h5"
    shutil.copy(chain.build / "optics.h5", path)
    opened, left = h5py.File, times

    def late(*args: object, **options: object) -> h5py.File:
        nonlocal left
        file = opened(*args, **options)
        if left:
            left -= 1
            shutil.copy(chain.build / "distortion.h5", other)
            other.replace(path)
        return file

    monkeypatch.setattr("tedm_cli.files.store.h5py.File", late)
    if times == 1000:  # without end
        with pytest.raises(InputError, match="was changed while it was read"), open_checked(path, DISTORTION):
            pass
    else:
        with open_checked(path, DISTORTION) as file:
            assert file.kind is DISTORTION
    assert left in (0, 1000 - 20)


# --- strings ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", FILES)
def test_every_string_is_under_a_checksum(chain: Project, name: str) -> None:
    """Arrays are in chunks with a checksum; scalars are in object headers of the version that has one."""

    def visit(path: str, item: object) -> None:
        if isinstance(item, h5py.Dataset) and item.dtype.kind not in "iuf":
            assert item.dtype.kind == "S", path
            if item.shape == ():
                assert item.id.get_create_plist().get_layout() == h5py.h5d.COMPACT, path
            elif item.size:
                assert item.fletcher32, path

    with h5py.File(chain.build / name) as file:
        file.visititems(visit)
        assert file.id.get_create_plist().get_version()[0] >= 2


def test_strings_of_any_alphabet(small: Project) -> None:
    replace(small.folder / "cases.toml", 'title = "Correlated outside', 'title = "Δθ ≤ 1 mK außen')
    small.stage("run-case").ok()
    path = small.build / "case03.h5"
    with h5py.File(path) as file:
        assert file["/case/title"].asstr()[()].startswith("Δθ ≤ 1 mK außen")
    with xarray.open_dataset(path, group="/area", engine="h5netcdf") as opened, h5py.File(path) as file:
        assert opened["group"].values.tolist() == file["/area/group"].asstr()[()].tolist()


def test_a_string_longer_than_a_header(small: Project) -> None:
    reason = "because " * 10_000
    replace(small.folder / "cases.toml", 'reason = "The shield separates', f'reason = "{reason}The shield separates')
    small.stage("run-case").ok()
    with h5py.File(small.build / "case03.h5") as file:
        assert file["/case/reason"].asstr()[()] == f"{reason}The shield separates two isothermal worlds."
