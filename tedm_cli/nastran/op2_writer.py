"""Write displacements as a Nastran OP2 file (table OUGV1) through pyNastran."""

from __future__ import annotations

import contextlib
import io
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from tedm_cli.errors import InputError
from tedm_cli.fem.structure import Floats, Ints
from tedm_cli.store import replacing

# The file keeps 10 id + device code in 32 bits.
MAX_GRID_ID = 99_999_999
MAX_LABEL = 128
# A constant date in the header: the same displacements give the same bytes. pyNastran replaces 1 January 2000 by today.
_DATE = (1, 2, 2000)
_GRID = 1


def write_op2(path: Path, grid_ids: Ints, cases: Iterable[tuple[int, str, Floats]]) -> None:
    """Write the displacements of static subcases; single precision, as Nastran does.

    The file is complete or absent: it is written beside the target under a temporary name, flushed to disk and renamed.

    Parameters
    ----------
    path : target, replaced if it exists.
    grid_ids : [N], 1 to 99,999,999.
    cases : subcase id, label (ASCII, at most 128 characters) and motion [N, 6] in m and rad, each subcase once.
        Consumed one by one; what is kept is 24 bytes per grid and case.

    Raises
    ------
    InputError
        For ids, labels or numbers that the format cannot hold, and repeated subcase ids.
    """
    from pyNastran.op2.op2 import OP2
    from pyNastran.op2.tables.oug.oug_displacements import RealDisplacementArray

    if len(grid_ids) == 0 or grid_ids.min() < 1 or grid_ids.max() > MAX_GRID_ID:
        raise InputError(f"grid ids must lie between 1 and {MAX_GRID_ID:,}", where=str(path))
    node_gridtype = np.column_stack([grid_ids, np.full(len(grid_ids), _GRID)]).astype(np.int32)
    model = OP2(debug=None)
    model.date = _DATE
    model.set_as_msc()
    for subcase, label, motion in cases:
        _check(path, subcase, label, motion, model.displacements)
        table = RealDisplacementArray.add_static_case(
            "OUGV1", node_gridtype, motion.astype(np.float32)[None], subcase, is_msc=True, label=label
        )
        table.lsdvmns = [subcase]
        model.displacements[subcase] = table
    if not model.displacements:
        raise InputError("no subcase to write", where=str(path))

    with replacing(path) as temporary, contextlib.redirect_stdout(io.StringIO()):  # pyNastran reports on stdout
        model.write_op2(str(temporary), post=-1, endian=b"<", nastran_format="msc")


def _check(path: Path, subcase: int, label: str, motion: Floats, written: dict[int, object]) -> None:
    where = f"{path}: subcase {subcase}"
    if subcase in written:
        raise InputError("the subcase id is used twice", where=where)
    if not label.isascii() or len(label) > MAX_LABEL:
        raise InputError(f"the label {label!r} is not plain ASCII of at most {MAX_LABEL} characters", where=where)
    if not np.isfinite(motion.astype(np.float32)).all():
        raise InputError("displacements are not finite in single precision", where=where)
