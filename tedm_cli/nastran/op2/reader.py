"""Displacement tables of an OP2: found in one pass over the file, then read one subcase at a time.

pyNastran walks the file (its records, byte order and word length); only the displacement tables are opened, every other
table is passed over. Layout of table OUG: DMAP Programmer's Guide, data blocks OUG and CASECC.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.errors import InputError
from tedm_cli.nastran.captured_output import captured_output, fact_of
from tedm_cli.nastran.op2.fortran_records import require_records

_TABLES = ("OUGV1", "OUG1", "BOUGV1", "OUGV2", "OUG2", "BOUGV2", "OUGV1PAT", "OPHIG", "BOPHIG")
_STRUCTURAL_GRID = 1  # grid type in the OP2; 2 marks scalar points
_HEADER_WORDS = 146
_ROW_WORDS = 8  # 10 id + device, grid type, three translations, three rotations
_STATICS = 1
_ANALYSES = {
    2: "modes (SOL 103)",
    5: "a frequency response",
    6: "a transient response",
    7: "buckling modes",
    8: "buckling modes",
    9: "complex modes",
    10: "nonlinear statics",
    11: "nonlinear statics",
}


@dataclass(frozen=True)
class SubcaseTable:
    """The displacements of one subcase in an OP2: what its header says, and where its records begin.

    `is_basic`: written in the basic frame, not in each grid's displacement frame (CD). `label`: as `clean_label` leaves
    it.
    """

    subcase: int
    label: str
    name: str
    is_basic: bool
    places: tuple[int, ...]


@dataclass(frozen=True)
class GridMotion:
    """Ids [n] and motion [n,6] (m, rad; frame of the table) of the grids of one subcase; scalar points are left out."""

    grid_id: IntArray
    motion: FloatArray


@contextmanager
def open_op2(path: Path) -> Iterator[tuple[list[SubcaseTable], Callable[[SubcaseTable], GridMotion]]]:
    """Open an OP2: the displacement tables in it, by subcase, and a function that reads one of them.

    Listing them reads their headers alone; a read holds one subcase.

    Raises
    ------
    InputError : missing, truncated or not an OP2, a dialect that is not recognised, no displacements, results of other
        than linear statics, SORT2, complex numbers, superelements, a subcase given twice.
    """
    from pyNastran.op2.op2 import OP2
    from pyNastran.op2.op2_interface.op2_scalar import OP2_Scalar

    require_records(path)
    model = OP2(debug=None)
    walk = _Walk(path)
    model.generalized_tables = walk
    model.skip_undefined_matrices = True
    model.is_vectorized, model.read_mode, model._close_op2 = True, 1, False
    try:
        with _damage(path):
            names = OP2_Scalar.read_op2(model, op2_filename=str(path))
        _check(walk, [n.decode("latin-1") for n in names], path)

        def read(table: SubcaseTable) -> GridMotion:
            with _damage(path):
                return _read(model, table, path)

        yield sorted(walk.found, key=lambda t: t.subcase), read
    finally:
        if getattr(model, "f", None) is not None:
            model.f.close()


@contextmanager
def _damage(path: Path) -> Iterator[None]:
    with captured_output() as chatter:
        try:
            yield
        except InputError:
            raise
        except Exception as exc:  # truncated files make pyNastran raise almost anything
            fact = fact_of(exc, chatter.getvalue())
            if "unknown version" in fact or isinstance(exc, NotImplementedError):
                raise InputError(
                    f"an OP2 of a Nastran that pyNastran does not recognise: {fact}",
                    where=str(path),
                    hint="files of MSC, NX (Simcenter), OptiStruct and MYSTRAN are read (PARAM,POST,-1)",
                ) from exc
            raise InputError(
                f"truncated or damaged; pyNastran says: {fact}",
                where=str(path),
                hint="is the file complete? did the solver end without a FATAL message?",
            ) from exc


class _Walk(dict[bytes, Any]):
    """Takes over pyNastran's tables by name: displacements are listed, all others of the usual form passed over."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.path = path
        self.found: list[SubcaseTable] = []
        self.temperatures: list[int] = []

    def __contains__(self, name: object) -> bool:
        from pyNastran.op2.op2_interface.op2_scalar import MATRIX_TABLES

        # Matrices have records of their own form, and PCOMPTS is known to.
        return name not in MATRIX_TABLES and not str(name).startswith("b'PCOMPT")

    def __getitem__(self, name: bytes) -> Callable[[Any], None]:
        return self._list if name.decode("latin-1").strip() in _TABLES else self._pass_over

    @staticmethod
    def _pass_over(model: Any) -> None:
        model.op2_reader._skip_table_helper(warn=False)

    def _list(self, model: Any) -> None:
        reader = model.op2_reader
        name = reader._read_table_name(rewind=False).decode("latin-1").strip()
        reader.read_markers([-1])
        reader._skip_record()
        reader.read_3_markers([-2, 1, 0])
        self._check_name(name, reader._read_record()[: 2 * reader.size], reader.size)
        subtable = -3
        reader.read_3_markers([subtable, 1, 0])
        header, places = b"", list[int]()
        while reader.get_nmarkers(1, rewind=True)[0] != 0:
            if reader._get_record_length() == _HEADER_WORDS * reader.size:
                self._add(name, header, places, model)
                header, places = reader._read_record(), []
            else:
                places.append(model.n)
                reader._skip_record()
            subtable -= 1
            reader.read_3_markers([subtable, 1, 0])
        self._add(name, header, places, model)
        reader.read_markers([0])

    def _check_name(self, name: str, again: bytes, size: int) -> None:
        """A table has its name twice; OUG and BOUG are the same rows in other frames (OUG1 is the name of any)."""
        inner = _text(again, size).decode("latin-1").strip(" \0")
        is_basic = inner.startswith("BOUG")
        if (is_basic or (inner.startswith("OUG") and inner != "OUG1")) and is_basic != name.startswith("B"):
            raise InputError(
                f"a table is named {name} and {inner}: the one is in the basic frame, the other is not",
                where=str(self.path),
                hint="the file is damaged: run the solver again",
            )

    def _add(self, name: str, header: bytes, places: list[int], model: Any) -> None:
        if not header:
            return
        words = np.frombuffer(header, _integers(model), count=50)
        subcase, analysis, code = int(words[3]), int(words[0]) // 10, int(words[1])
        wide, thermal = int(words[9]), int(words[22])
        _, subtitle, label = _titles(header, model)
        where = f"{self.path}: subcase {subcase}"
        if "SUPERELEMENT" in subtitle[67:].upper():
            raise InputError(
                f"results of a superelement ({' '.join(subtitle[67:].split())}) are not read",
                where=where,
                hint="solve the model in one piece",
            )
        if thermal == 1:
            self.temperatures.append(subcase)
            return
        kind = _ANALYSES.get(analysis)
        if kind or thermal or analysis != _STATICS:
            kind = kind or (f"response spectra (code {thermal})" if thermal else f"results of analysis code {analysis}")
            raise InputError(f"holds {kind}, not static displacements", where=where, hint="solve with SOL 101")
        if code % 1000 != 1:
            return  # velocities, accelerations
        # Function code 1 of the Programmer's Guide: SORT2 where the thousands are 2, 3 or 6.
        if code // 1000 in (2, 3, 6) or name.endswith("2"):
            raise InputError(
                "displacements sorted by grid (SORT2) are not read",
                where=where,
                hint="request DISPLACEMENT(PLOT,SORT1) = ALL",
            )
        if wide != _ROW_WORDS or name == "OUGV1PAT":
            what = "complex displacements" if wide == 14 else f"displacements in rows of {wide} words (table {name})"
            raise InputError(f"{what} are not read", where=where, hint="request DISPLACEMENT(PLOT,REAL) = ALL")
        self.found.append(SubcaseTable(subcase, clean_label(label), name, name.startswith("B"), tuple(places)))


def clean_label(label: str) -> str:
    """A LABEL without what Nastran appends (`SUBCASE n`, `PVAL ID = n`) and with single blanks."""
    text = re.sub(r"(^|\s{2,})(SUBCASE|SUBCOM|SYM|SYMCOM|REPCASE)\s*=?\s*\d+\s*$", "", label.strip(" \0"), flags=re.I)
    text = re.sub(r"(^|\s{2,})PVAL ID\s*=\s*\d+\s*$", "", text.strip(), flags=re.I)
    return " ".join(text.split())


def _titles(header: bytes, model: Any) -> tuple[str, str, str]:
    """Title, subtitle and label of a header record."""
    size = model.op2_reader.size
    fields = (header[50 * size + i * 32 * size :][: 32 * size] for i in range(3))
    title, subtitle, label = (_text(f, size).decode("latin-1") for f in fields)
    return title, subtitle, label


def _text(field: bytes, size: int) -> bytes:
    """Text of a field of words; 64-bit files have four characters to the word (NX), or eight (MSC)."""
    if size == 4:
        return field
    words = np.frombuffer(field, np.uint8).reshape(-1, 8)
    interlaced = np.isin(words[:, 4:], (0, ord(" "))).all()
    return words[:, :4].tobytes() if interlaced else field[: len(field) // 2]


def _integers(model: Any) -> str:
    return f"{model._uendian}i{model.op2_reader.size}"


def _check(walk: _Walk, names: list[str], path: Path) -> None:
    if not walk.found:
        if walk.temperatures:
            raise InputError(
                f"holds temperatures (heat transfer, subcase {walk.temperatures[0]}) and no displacements",
                where=str(path),
                hint="give the OP2 of the static analysis",
            )
        raise InputError(
            f"holds no displacements (tables: {', '.join(dict.fromkeys(names)) or 'none'})",
            where=str(path),
            hint="the deck needs DISPLACEMENT(PLOT) = ALL and PARAM,POST,-1",
        )
    for subcase, times in Counter(t.subcase for t in walk.found).items():
        if times > 1:
            tables = ", ".join(sorted({t.name for t in walk.found if t.subcase == subcase}))
            raise InputError(f"subcase {subcase} occurs {times} times (table {tables})", where=str(path))


def _read(model: Any, table: SubcaseTable, path: Path) -> GridMotion:
    reader = model.op2_reader
    size, order = reader.size, model._uendian
    records = []
    for place in table.places:
        reader._goto(place)
        records.append(reader._read_record())
    data = records[0] if len(records) == 1 else b"".join(records)
    if not data or len(data) % (_ROW_WORDS * size):
        raise InputError(f"{len(data)} bytes are no rows of displacements", where=f"{path}: subcase {table.subcase}")
    whole = np.frombuffer(data, f"{order}i{size}").reshape(-1, _ROW_WORDS)
    real = np.frombuffer(data, f"{order}f{size}").reshape(-1, _ROW_WORDS)
    grids: Any = whole[:, 1] == _STRUCTURAL_GRID
    if grids.all():
        grids = slice(None)  # a mask takes several times as long
    return GridMotion((whole[grids, 0] // 10).astype(np.int64), real[grids, 2:].astype(np.float64))
