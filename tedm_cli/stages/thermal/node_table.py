"""Tables of temperatures of thermal nodes over time, as `[[series]]` with of = "nodes" reads them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.errors import InputError, UsageError
from tedm_cli.files.columns import HDF5_SUFFIXES, writing_columns
from tedm_cli.files.store import replacing

FORMATS = (".csv", *HDF5_SUFFIXES)
Write = Callable[[FloatArray, FloatArray], None]


def require_format(path: Path | None) -> None:
    """Refuse a name that says no format."""
    if path is not None and path.suffix.lower() not in FORMATS:
        raise UsageError(f"-o {path}: must end in {', '.join(FORMATS[:-1])} or {FORMATS[-1]}")


@contextmanager
def node_table(path: Path | None, nodes: Sequence[str]) -> Iterator[Write]:
    """A function that takes the next stamps [T] and temperatures [n, T]; nothing is written without a path.

    Raises
    ------
    InputError : a name of a node that the format cannot hold; a file that cannot be written.
    """
    if path is None:
        yield lambda time_s, temperature: None
        return
    names = ["time_s", *nodes]
    if path.suffix.lower() in HDF5_SUFFIXES:
        _require_names(nodes, "/", path, "take a .csv")
        with writing_columns(path, names) as write:
            yield lambda time_s, temperature: write(np.concatenate([time_s[None], temperature]))
        return
    _require_names(nodes, ",;\"'", path, "take a .h5")
    with replacing(path) as temporary, open(temporary, "w", encoding="utf-8", newline="\n") as stream:
        stream.write(",".join(names) + "\n")

        def write_rows(time_s: FloatArray, temperature: FloatArray) -> None:
            np.savetxt(stream, np.column_stack([time_s, temperature.T]), "%.12g", ",")

        yield write_rows


def _require_names(nodes: Sequence[str], signs: str, path: Path, hint: str) -> None:
    odd = next((name for name in nodes if any(sign in name for sign in signs) or name in ("time_s", "..", ".")), None)
    if odd is not None:
        raise InputError(f"a column cannot be called {odd!r}", where=str(path), hint=hint)
