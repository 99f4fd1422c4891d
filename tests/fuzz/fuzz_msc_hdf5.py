"""What goes wrong with MSC Nastran's HDF5: damage of bytes, and tables that say something else."""

from __future__ import annotations

import io
from collections.abc import Callable
from random import Random

import fuzz_hdf5
import h5py
import numpy as np
from fuzz_text import Mutation
from msc_hdf5_file import CASES, DISPLACEMENT, DOMAINS, INDEX
from numpy.lib.recfunctions import repack_fields

MSC_HDF5: dict[str, Mutation] = {}
_WORDS = (0, -1, 1, 2, 3, 7, 10, 2**31 - 1, -(2**63), 2**63 - 1)
_FLOATS = (float("nan"), float("inf"), -float("inf"), 1e-300, 3.4e38, -0.0, 1.0, 1e-3)
_TABLES = (DISPLACEMENT, DOMAINS, CASES, INDEX)


def _damage(name: str) -> Mutation:
    """Damage of bytes as of files between the stages; no seal tells of it here."""
    change: fuzz_hdf5.Damage = getattr(fuzz_hdf5, name)
    return lambda random, data: bytes(change(random, bytearray(data)))


MSC_HDF5.update({name: _damage(name) for name in fuzz_hdf5.DAMAGE})


def edit(change: Callable[[Random, h5py.File], None]) -> Callable[[Random, h5py.File], None]:
    """A change of what a sound HDF5 file says."""

    def mutate(random: Random, data: bytes) -> bytes:
        held = io.BytesIO(data)
        with h5py.File(held, "r+") as file:
            change(random, file)
        return held.getvalue()

    MSC_HDF5[change.__name__] = mutate
    return change


def _put(file: h5py.File, table: str, rows: np.ndarray) -> None:
    del file[table]
    file[table] = rows


@edit
def no_table(random: Random, file: h5py.File) -> None:
    del file[random.choice(_TABLES)]


@edit
def no_column(random: Random, file: h5py.File) -> None:
    table = random.choice(_TABLES)
    rows = file[table][()]
    gone = random.choice(rows.dtype.names)
    _put(file, table, repack_fields(rows[[n for n in rows.dtype.names if n != gone]]))


@edit
def other_type(random: Random, file: h5py.File) -> None:
    table = random.choice(_TABLES)
    rows = file[table][()]
    changed = random.choice([n for n in rows.dtype.names if rows.dtype[n].kind in "if"])
    kind = random.choice(("<f4", "<i4", ">f8", ">i8", "<u2", "S8"))
    _put(file, table, rows.astype([(n, kind if n == changed else rows.dtype[n]) for n in rows.dtype.names]))


@edit
def single_precision(random: Random, file: h5py.File) -> None:
    """All motions as columns of 32 bits."""
    rows = file[DISPLACEMENT][()]
    kinds = [(n, "<f4" if rows.dtype[n].kind == "f" else rows.dtype[n]) for n in rows.dtype.names]
    _put(file, DISPLACEMENT, rows.astype(kinds))


@edit
def foreign_word(random: Random, file: h5py.File) -> None:
    """A whole number of a domain, of the index or of a row of displacements."""
    table = random.choice((DOMAINS, INDEX, DISPLACEMENT, CASES))
    rows = file[table][()]
    columns = [n for n in rows.dtype.names if rows.dtype[n].kind == "i"]
    rows[random.choice(columns)][random.randrange(len(rows))] = random.choice(_WORDS)
    file[table][...] = rows


@edit
def foreign_number(random: Random, file: h5py.File) -> None:
    rows = file[DISPLACEMENT][()]
    rows[random.choice(rows.dtype.names[1:7])][random.randrange(len(rows))] = random.choice(_FLOATS)
    file[DISPLACEMENT][...] = rows


@edit
def scaled_number(random: Random, file: h5py.File) -> None:
    rows = file[DISPLACEMENT][()]
    factor = random.choice((-1.0, 2.0, 1.01, 1.0001, 1.000001, 1.00000001, 0.0))
    rows[random.choice(rows.dtype.names[1:7])][random.randrange(len(rows))] *= factor
    file[DISPLACEMENT][...] = rows


@edit
def moved_rows(random: Random, file: h5py.File) -> None:
    """Rows of displacements in another order, lost, or there twice."""
    rows = file[DISPLACEMENT][()]
    a, b = sorted(random.sample(range(len(rows)), 2))
    changed = random.choice(
        (rows[::-1], np.roll(rows, a), np.delete(rows, a), np.concatenate([rows, rows[a:b]]), rows[:a], rows[b:])
    )
    _put(file, DISPLACEMENT, changed)
    if random.random() < 0.7:
        del file[INDEX]  # it would tell


@edit
def swapped_words(random: Random, file: h5py.File) -> None:
    """Labels, or numbers of subcases or domains, that have changed places."""
    table, column = random.choice(((CASES, "LABEL"), (CASES, "SID"), (DOMAINS, "SUBCASE"), (DOMAINS, "ID")))
    rows = file[table][()]
    a, b = random.sample(range(len(rows)), 2)
    rows[column][[a, b]] = rows[column][[b, a]]
    file[table][...] = rows


@edit
def other_schema(random: Random, file: h5py.File) -> None:
    file.attrs["SCHEMA"] = random.choice((np.array([20251]), 0, -3, "20200", "tedm", np.zeros(0, int)))
