"""What the readers of result files tell of a subcase, whichever kind of file it is in."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass

from tedm_cli.arrays import FloatArray, IntArray

STATICS = 1
#: Analyses that are no linear statics, by their code in OP2 and HDF5.
ANALYSES = {
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
    """The displacements of one subcase in a result file, as far as they can be told without reading them.

    `label`: as `clean_label` leaves it. `name`: of the table in the file. `is_basic`: written in the basic frame, not
    in each grid's displacement frame (CD). `places`: where its records begin, in an OP2. `labelled`: whether the file
    has labels at all.
    """

    subcase: int
    label: str
    name: str
    is_basic: bool
    places: tuple[int, ...] = ()
    labelled: bool = True


@dataclass(frozen=True)
class GridMotion:
    """Ids [n] and motion [n,6] (length of the deck, rad; frame of the table) of the points of one subcase.

    `double`: there are numbers among them that single precision does not hold.
    """

    grid_id: IntArray
    motion: FloatArray
    double: bool = False


#: Reads the displacements of a subcase.
ReadTable = Callable[[SubcaseTable], GridMotion]


def clean_label(label: str) -> str:
    """A LABEL without what Nastran appends (`SUBCASE n`, `PVAL ID = n`) and with single blanks."""
    text = re.sub(r"(^|\s{2,})(SUBCASE|SUBCOM|SYM|SYMCOM|REPCASE)\s*=?\s*\d+\s*$", "", label.strip(" \0"), flags=re.I)
    text = re.sub(r"(^|\s{2,})PVAL ID\s*=\s*\d+\s*$", "", text.strip(), flags=re.I)
    return " ".join(text.split())
