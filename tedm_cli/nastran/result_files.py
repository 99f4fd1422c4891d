"""Result files of Nastran, OP2 or MSC's HDF5: told apart by what is in them, and read in one way."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tedm_cli.files.record_tables import is_hdf5
from tedm_cli.nastran.msc_hdf5 import open_msc_hdf5
from tedm_cli.nastran.op2.fortran_records import require_records
from tedm_cli.nastran.op2.reader import open_op2
from tedm_cli.nastran.subcase_table import ReadTable, SubcaseTable


@contextmanager
def open_result_file(path: Path) -> Iterator[tuple[list[SubcaseTable], ReadTable]]:
    """Open a result file: its displacement tables by subcase, and a function that reads one of them.

    Raises
    ------
    InputError : what `open_op2` and `open_msc_hdf5` refuse.
    """
    with open_msc_hdf5(path) if is_hdf5(path) else open_op2(path) as opened:
        yield opened


def require_whole(path: Path) -> None:
    """Refuse what is no result file, or not to its end, before anything else is read.

    Raises
    ------
    InputError : missing, of another kind, cut off or damaged as far as the file's own records tell.
    """
    if not is_hdf5(path):
        require_records(path)
        return
    with open_msc_hdf5(path):
        pass
