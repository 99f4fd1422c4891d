"""Results in the layout of MSC Nastran's HDF5 (SCHEMA 20200), as a file that it wrote shows it."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import h5py
import numpy as np

DOMAINS = "/NASTRAN/RESULT/DOMAINS"
NODAL = "/NASTRAN/RESULT/NODAL"
DISPLACEMENT = f"{NODAL}/DISPLACEMENT"
INDEX = f"/INDEX{DISPLACEMENT}"
CASES = "/NASTRAN/INPUT/PARAMETER/CASECC/SUBCASE"
MOTION = ("X", "Y", "Z", "RX", "RY", "RZ")
ROW = np.dtype([("ID", "<i8"), *((name, "<f8") for name in MOTION), ("DOMAIN_ID", "<i8")])
DOMAIN = np.dtype(
    [
        *((name, "<i8") for name in ("ID", "SUBCASE", "STEP", "ANALYSIS")),
        *((name, "<f8") for name in ("TIME_FREQ_EIGR", "EIGI")),
        *((name, "<i8") for name in ("MODE", "DESIGN_CYCLE", "RANDOM", "SE", "AFPM", "TRMC")),
        *((name, "<i8") for name in ("INSTANCE", "MODULE", "SUBSTEP", "IMPFID")),
    ]
)
CASE = np.dtype([("SID", "<i8"), ("SPCSET", "<i8"), ("TITLE", "S128"), ("SUBTITLE", "S128"), ("LABEL", "S128")])
PLACE = np.dtype([("DOMAIN_ID", "<i8"), ("POSITION", "<i8"), ("LENGTH", "<i8")])
Motions = Iterable[tuple[int, str, np.ndarray]]


def write_msc_hdf5(
    path: Path, ids: np.ndarray, cases: Motions, *, labels: bool = True, index: bool = True, order: int | None = None
) -> None:
    """Subcase, label and motion [n, 6] of each case, with domains numbered from 1.

    `labels`: with the case control, as MSC writes it unless asked not to. `order`: seed of another order of the
    subcases' rows, each in two parts.
    """
    cases = list(cases)
    domains = np.zeros(len(cases), DOMAIN)
    parts = []
    for number, (subcase, _, motion) in enumerate(cases, start=1):
        for name, value in (("ID", number), ("SUBCASE", subcase), ("ANALYSIS", 1)):
            domains[name][number - 1] = value
        rows = np.zeros(len(ids), ROW)
        rows["ID"], rows["DOMAIN_ID"] = ids, number
        for column, name in enumerate(MOTION):
            rows[name] = motion[:, column]
        parts += [rows] if order is None else np.array_split(rows, 2)
    if order is not None:
        random = np.random.default_rng(order)
        parts = [parts[i] for i in random.permutation(len(parts))]
        random.shuffle(domains)
    ends = np.cumsum([0, *map(len, parts)])
    places = [(int(part["DOMAIN_ID"][0]), int(first), len(part)) for part, first in zip(parts, ends[:-1], strict=True)]
    with h5py.File(path, "w") as file:
        file.attrs["SCHEMA"] = np.array([20200])
        _table(file, DOMAINS, domains, 260, 20200)
        _table(file, DISPLACEMENT, np.concatenate(parts), 510, 1)
        if index:
            file[INDEX] = np.array(places, PLACE)
        if labels:
            texts = [(n, 1, b"", b"", f"{label:<103} SUBCASE {n:<14}".encode()) for n, label, _ in cases]
            _table(file, CASES, np.array(texts, CASE), 10, 1)


def _table(file: h5py.File, path: str, rows: np.ndarray, chunk: int, version: int) -> None:
    made = file.create_dataset(path, data=rows, chunks=(chunk,), maxshape=(None,), compression="gzip")
    made.attrs["version"] = np.array([version])


def change_table(path: Path, table: str, rows: np.ndarray | None) -> None:
    """Put other rows in place of a table's; None takes it away."""
    with h5py.File(path, "r+") as file:
        del file[table]
        if rows is not None:
            file[table] = rows


def table_of(path: Path, table: str) -> np.ndarray:
    with h5py.File(path) as file:
        return np.asarray(file[table][()])
