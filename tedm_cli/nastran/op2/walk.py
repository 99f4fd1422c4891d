"""One pass over the tables of an OP2: where displacements and weights begin, and where a file is damaged.

pyNastran walks the file (its records, byte order and word length); displacement and weight tables are listed, every
other table is passed over. Layout of table OUG: DMAP Programmer's Guide, data blocks OUG and CASECC.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.errors import InputError
from tedm_cli.nastran.captured_output import captured_output, fact_of
from tedm_cli.nastran.library import require_pynastran, without_integration
from tedm_cli.nastran.op2.fortran_records import require_records
from tedm_cli.nastran.subcase_table import ANALYSES, STATICS, SubcaseTable, clean_label

_TABLES = ("OUGV1", "OUG1", "BOUGV1", "OUGV2", "OUG2", "BOUGV2", "OUGV1PAT", "OPHIG", "BOPHIG")
_WEIGHTS = ("OGPWG", "OGPWGM")
_HEADER_WORDS = 146
_WEIGHT_WORDS = 78  # the 6 x 6 matrix, axes and sums
ROW_WORDS = 8  # 10 id + device, grid type, three translations, three rotations


@dataclass(frozen=True)
class WeightRecord:
    """A solver's mass matrix [6, 6] of rigid motions about a grid (0: the origin)."""

    grid: int
    matrix: FloatArray


@contextmanager
def walked(path: Path) -> Iterator[tuple[Walk, Any]]:
    """The tables of an OP2, and the pyNastran model that holds it open.

    Raises
    ------
    InputError : missing, truncated or not an OP2, a dialect that is not recognised, tables that are not listed (see
        `Walk`).
    """
    require_pynastran()
    with without_integration():
        from pyNastran.op2.op2 import OP2
        from pyNastran.op2.op2_interface.op2_scalar import OP2_Scalar

    require_records(path)
    model = OP2(debug=None)
    walk = Walk(path)
    model.generalized_tables = walk
    model.skip_undefined_matrices = True
    model.is_vectorized, model.read_mode, model._close_op2 = True, 1, False
    try:
        with walk.damage(model):
            names = OP2_Scalar.read_op2(model, op2_filename=str(path))
        walk.names = [n.decode("latin-1") for n in names]
        yield walk, model
    finally:
        if getattr(model, "f", None) is not None:
            model.f.close()


class Walk(dict[bytes, Any]):
    """Takes over pyNastran's tables by name: displacements and weights are listed, all others passed over.

    names : of all tables; found : displacement tables; weights : grid point weight tables; temperatures : subcases with
    temperatures in place of displacements. What a displacement table holds besides static displacements, sorted by
    subcase, in real numbers, of a model in one piece, is refused (`InputError`).
    """

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.path = path
        self.names: list[str] = []
        self.found: list[SubcaseTable] = []
        self.weights: list[WeightRecord] = []
        self.temperatures: list[int] = []
        self._table, self._subcase = "", 0
        self._sound = 0  # byte up to which all is well

    def __contains__(self, name: object) -> bool:
        from pyNastran.op2.op2_interface.op2_scalar import MATRIX_TABLES

        table = name.decode("latin-1").strip() if isinstance(name, bytes) else ""
        if table != self._table:  # pyNastran asks again when it gives up
            self._table, self._subcase = table, 0
        # Matrices have records of their own form, and PCOMPTS is known to.
        return name not in MATRIX_TABLES and not str(name).startswith("b'PCOMPT")

    def __getitem__(self, name: bytes) -> Callable[[Any], None]:
        plain = name.decode("latin-1").strip()
        return self._list if plain in _TABLES else self._weigh if plain in _WEIGHTS else self._pass_over

    @contextmanager
    def damage(self, model: Any, table: SubcaseTable | None = None) -> Iterator[None]:
        """Say where a file is damaged when pyNastran gives up within: byte, table, and subcase where it is known."""
        if table is not None:
            self._table, self._subcase, self._sound = table.name, table.subcase, min(table.places, default=0)
        with captured_output() as chatter:
            try:
                yield
            except InputError:
                raise
            except Exception as exc:  # damaged files make pyNastran raise almost anything
                fact = fact_of(exc, chatter.getvalue())
                version = re.search(r"unknown version.{,140}", str(exc))
                if version or isinstance(exc, NotImplementedError):
                    raise InputError(
                        f"an OP2 of a Nastran that pyNastran does not recognise: {version[0] if version else fact}",
                        where=str(self.path),
                        hint="files of MSC, NX (Simcenter), OptiStruct and MYSTRAN are read (PARAM,POST,-1)",
                    ) from exc
                last = max(int(getattr(model, "n", 0)), self._sound)
                raise InputError(
                    f"damaged between bytes {self._sound:,} and {last:,}: not as Nastran writes {self._place()}",
                    where=str(self.path),
                    hint="is the file complete? did the solver end without a FATAL message?",
                ) from exc

    def _place(self) -> str:
        if not self._table:
            return "the head of an OP2"
        return f"table {self._table}" + (f" in subcase {self._subcase}" if self._subcase else "")

    def _pass_over(self, model: Any) -> None:
        self._sound = int(model.n)
        model.op2_reader._skip_table_helper(warn=False)

    def _list(self, model: Any) -> None:
        reader = model.op2_reader
        self._subcase = 0
        name, again = self._begin(model)
        self._check_name(name, again, reader.size)
        header, places = b"", list[int]()
        for length in self._records(model):
            if length == _HEADER_WORDS * reader.size:
                self._add(name, header, places, model)
                header, places = reader._read_record(), []
                self._subcase = int(np.frombuffer(header, _integers(model), count=4)[3])
            else:
                places.append(model.n)
                reader._skip_record()
        self._add(name, header, places, model)

    def _weigh(self, model: Any) -> None:
        """Of a weight table the matrix alone: what follows in it each solver makes in its own way."""
        reader, (order, size) = model.op2_reader, (model._uendian, model.op2_reader.size)
        self._begin(model)
        grid = 0
        for length in self._records(model):
            record = reader._read_record()
            if length == _HEADER_WORDS * size:
                grid = int(np.frombuffer(record, _integers(model), count=3)[2])
            elif length == _WEIGHT_WORDS * size:
                matrix = np.frombuffer(record, f"{order}f{size}", count=36).reshape(6, 6)
                self.weights.append(WeightRecord(grid, matrix.astype(np.float64)))
            else:
                raise InputError(
                    f"table {self._table} has a record of {length:,} bytes before byte {model.n:,},"
                    " which no weight table has",
                    where=str(self.path),
                    hint="the file is damaged: run the solver again",
                )

    def _begin(self, model: Any) -> tuple[str, bytes]:
        """The name of a table, and the name that it has within."""
        self._sound, reader = int(model.n), model.op2_reader
        name = reader._read_table_name(rewind=False).decode("latin-1").strip()
        reader.read_markers([-1])
        reader._skip_record()
        reader.read_3_markers([-2, 1, 0])
        return name, reader._read_record()[: 2 * reader.size]

    def _records(self, model: Any) -> Iterator[int]:
        """Lengths in bytes of the records of a table; each is read or passed over before the next is asked for."""
        reader, subtable = model.op2_reader, -3
        reader.read_3_markers([subtable, 1, 0])
        while reader.get_nmarkers(1, rewind=True)[0] != 0:
            self._sound = int(model.n)
            yield int(reader._get_record_length())
            subtable -= 1
            reader.read_3_markers([subtable, 1, 0])
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
        kind = ANALYSES.get(analysis)
        if kind or thermal or analysis != STATICS:
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
        if wide != ROW_WORDS or name == "OUGV1PAT":
            what = "complex displacements" if wide == 14 else f"displacements in rows of {wide} words (table {name})"
            raise InputError(f"{what} are not read", where=where, hint="request DISPLACEMENT(PLOT,REAL) = ALL")
        self.found.append(SubcaseTable(subcase, clean_label(label), name, name.startswith("B"), tuple(places)))


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
