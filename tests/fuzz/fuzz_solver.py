"""What the embedded solver reads of a damaged deck, against the same deck in plain writing.

pyNastran reads the deck and writes it again, in fields of one width, without comments and replications: what the solver
takes from both must be the same structure and the same loads.
"""

from __future__ import annotations

import codecs
import contextlib
import dataclasses
import os
import warnings
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from tedm_cli.errors import TedmError
from tedm_cli.nastran.structure.deck import read_solver_deck

WRITTEN = 1e-7  # relative: numbers in fields of 16 columns
Parts = dict[str, np.ndarray]


def solver_parts(path: Path) -> Parts:
    """Every array, number and word that the solver takes from a deck, by its place."""
    return dict(_leaves(read_solver_deck(path), ""))


def compare_decks(found: Parts, sound: Parts, path: Path) -> tuple[str, str]:
    """The outcome for a deck that was read."""
    if not differences(found, sound):
        return "same", ""
    try:
        wanted = solver_parts(plain_deck(path))
    except TedmError as exc:
        return "SILENT", f"refused in plain writing: {exc}"
    except Exception as exc:
        return "SILENT", f"taken, where pyNastran reads nothing: {type(exc).__name__}: {exc}"
    differ = differences(found, wanted)
    return (
        ("SILENT", f"read as something else in plain writing: {', '.join(differ[:4])}") if differ else ("meaning", "")
    )


def plain_deck(path: Path) -> Path:
    """The deck as pyNastran writes it, beside it."""
    from pyNastran.bdf.bdf import BDF

    out = path.with_name("plain.bdf")
    out.write_bytes(path.read_bytes().removeprefix(codecs.BOM_UTF8))  # which pyNastran takes for text
    with open(os.devnull, "w") as null, contextlib.redirect_stdout(null), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        model = BDF(debug=None)
        model._parse_primary_file_header = lambda _: None
        model.read_bdf(str(out), xref=False, punch=False, encoding="latin-1")
        model.write_bdf(str(out), size=16, is_double=False, enddata=True)
    # A lower-case end of the executive control is written beside another one.
    lines = out.read_bytes().split(b"\n")
    out.write_bytes(b"\n".join(line for line in lines if line.strip() != b"cend"))
    return out


def differences(a: Parts, b: Parts) -> list[str]:
    """Places where two readings differ."""
    return sorted(k for k in {*a, *b} if k not in a or k not in b or not _alike(a[k], b[k]))


def _alike(a: np.ndarray, b: np.ndarray) -> bool:
    if a.shape != b.shape:
        return False
    if a.dtype.kind == b.dtype.kind == "f":
        return np.allclose(a, b, rtol=WRITTEN, atol=0.0, equal_nan=True)
    return np.array_equal(a, b)


def _leaves(value: object, at: str) -> Iterator[tuple[str, np.ndarray]]:
    if dataclasses.is_dataclass(value):
        for part in dataclasses.fields(value):
            yield from _leaves(getattr(value, part.name), f"{at}.{part.name}")
    elif isinstance(value, (list, tuple)):
        yield f"{at}#", np.array(len(value))
        for i, part in enumerate(value):
            yield from _leaves(part, f"{at}[{i}]")
    elif value is None or isinstance(value, str):
        yield at, np.array(str(value))
    else:
        yield at, np.asarray(value)
