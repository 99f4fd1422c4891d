"""Thermal models of ESATAN-TMS: `.TMD` files are HDF5, of the layout that public readers (pycanha and others) know.

In the group AnalysisSet1, whose attribute `TAbs` is the offset that makes kelvin of its temperatures: `thermalNodes`
[n, ...] (numbers of nodes first), `conductorsGL` and `conductorsGR` [m, 2] (places of nodes, from 1), names of
quantities in `thermalNodesRealAttributes` and `thermalNodesStringAttributes`; in its group DataGroup1: `times` [t],
`thermalNodesRealData` and `thermalNodesStringData` [t, n, quantity], `conductorDataGL` and `conductorDataGR` [t, m, 1].
"""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from tedm_cli.arrays import AnyArray, FloatArray, IndexArray, IntArray
from tedm_cli.errors import InputError
from tedm_cli.files.blocks import reading
from tedm_cli.files.elsewhere import kept_elsewhere, links_elsewhere
from tedm_cli.files.seal import Identity, identity_of
from tedm_cli.files.trial import REFUSED, trial
from tedm_cli.regular_file import require_regular_file

_ANALYSIS, _DATA = "AnalysisSet1", "DataGroup1"
_OFFSET = "tabs"
_POWERS = ("QA", "QE", "QI", "QR", "QS")  # albedo, planet, internal, heaters and others, sun
_HINT = "write the thermal model data again with ESATAN-TMS, with nodes, conductors and temperatures"
INACTIVE = "X"
"""Kind of a node that takes no part."""
_SAME_S = 1e-6  # seconds
_BLOCK = 1 << 20  # numbers read at once


@dataclass(frozen=True, eq=False)
class TmdModel:
    """What a file says of a model at one of its times.

    number : [n], of the nodes. kind : [n], D, A, B, X or others. temperature, capacity (J/K), power (W) : [n].
    offset_K : what makes kelvin of the temperatures, None where the file does not say. time_s : which it is.
    GL (W/K), GR (m²) : two nodes [m, 2] as places from 0, and values [m].
    """

    number: IntArray
    kind: list[str]
    temperature: FloatArray
    capacity: FloatArray
    power: FloatArray
    offset_K: float | None
    time_s: float
    GL: tuple[IntArray, FloatArray]
    GR: tuple[IntArray, FloatArray]


@dataclass(frozen=True, eq=False)
class TmdTemperatures:
    """The temperatures of an open file over time; made by `open_tmd_temperatures`.

    node : [n], numbers of all nodes but inactive ones, as text. time_s : [t]. offset_K : as in `TmdModel`.
    """

    node: list[str]
    time_s: FloatArray
    offset_K: float | None
    _file: _Tmd
    _active: IndexArray

    def read(self, part: slice) -> FloatArray:
        """Temperatures [times, n] at some of the times, in the unit of the file."""
        return np.take(self._file.temperatures(part), self._active, axis=1)


@contextlib.contextmanager
def open_tmd_temperatures(path: Path) -> Iterator[TmdTemperatures]:
    """Open a file for its temperatures over time, which are read in blocks.

    Raises
    ------
    InputError : missing, not HDF5, damaged, with data in other files, of another layout, or a node twice.
    """
    _try_once(path)
    with _opened(path) as file:
        kind = file.kinds(slice(0, 1))
        active = np.flatnonzero([k != INACTIVE for k in kind])
        node = [str(n) for n in file.number[active].tolist()]
        if len(set(node)) < len(node):
            raise file.refused(f"node {next(n for n in node if node.count(n) > 1)} is there twice")
        yield TmdTemperatures(node, file.times, file.offset(), file, active)


def read_tmd(path: Path, time_s: float | None) -> TmdModel:
    """The model at `time_s`, or at the last of its times.

    Raises
    ------
    InputError : missing, not HDF5, damaged, with data in other files, of another layout, or without that time.
    """
    _try_once(path)
    return _read(path, time_s)


def _try_once(path: Path) -> None:
    require_regular_file(path)
    try:
        _try(path, identity_of(path))
    except FileNotFoundError:
        raise InputError("no such file", where=str(path)) from None
    except OSError as exc:
        raise InputError(f"cannot be read ({exc.strerror})", where=str(path)) from None


def _read(path: Path, time_s: float | None) -> TmdModel:
    with _opened(path) as file:
        return file.model(time_s)


@contextlib.contextmanager
def _opened(path: Path) -> Iterator[_Tmd]:
    try:
        opened = h5py.File(path, "r")
    except OSError:
        raise InputError("not a readable HDF5 file (truncated or damaged)", where=str(path), hint=_HINT) from None
    with opened as file, reading(path, hint=_HINT):
        for problem in links_elsewhere(file, soft=True):
            raise InputError(problem, where=str(path), hint="copy the data into the file itself")
        yield _Tmd(file, path)


class _Tmd:
    """An open file."""

    def __init__(self, file: Any, path: Path) -> None:
        self._path = path
        self._analysis = self._group(file, _ANALYSIS)
        self._data = self._group(self._analysis if _DATA in self._analysis else file, _DATA)
        numbers = self._array(self._analysis, "thermalNodes", "iu", None)
        self.number: IntArray = np.asarray(numbers.reshape(len(numbers), -1)[:, 0], dtype=np.int64)
        self.times: FloatArray = np.asarray(self._array(self._data, "times", "f", 1), dtype=np.float64)
        if not len(self.times):
            raise self.refused("holds no time, so no temperatures")
        names = self._words(self._array(self._analysis, "thermalNodesRealAttributes", "SO", 1))
        t, n = len(self.times), len(self.number)
        real = self._dataset(self._data, "thermalNodesRealData", "f", 3)
        self._shape("thermalNodesRealData", real.shape, (t, n, len(names)), "times, nodes, quantities")
        words = self._dataset(self._data, "thermalNodesStringData", "SO", 3)
        self._shape("thermalNodesStringData", words.shape, (t, n, words.shape[2]), "times, nodes, words")
        if lost := [name for name in ("T", "C") if name not in names]:
            held = ", ".join(names[:20])
            raise self.refused(f"thermalNodesRealAttributes has no quantity {lost[0]}; it has {held}")
        self._names, self._real, self._string = names, real, words

    def model(self, time_s: float | None) -> TmdModel:
        at = self._time(self.times, time_s)
        one = slice(at, at + 1)

        def quantity(name: str) -> FloatArray:
            found: FloatArray = self._quantity(name, one)[0]
            return found

        power = sum((quantity(q) for q in _POWERS if q in self._names), np.zeros(len(self.number)))
        conductors = [self._conductors(name, at, len(self.times), len(self.number)) for name in ("GL", "GR")]
        return TmdModel(
            self.number, self.kinds(one), quantity("T"), quantity("C"), power, self.offset(), float(self.times[at]),
            *conductors,
        )  # fmt: skip

    def temperatures(self, part: slice) -> FloatArray:
        """[times, n] of all nodes, in the unit of the file."""
        return self._quantity("T", part)

    def kinds(self, one: slice) -> list[str]:
        """Kind of each node at one time."""
        with reading(self._path, self._string.name, _HINT):
            found = np.asarray(self._string[one, :, 0])[0]
        return [word[:1].upper() for word in self._words(found)]

    def _quantity(self, name: str, part: slice) -> FloatArray:
        with reading(self._path, self._real.name, _HINT):
            return np.asarray(self._real[part, :, self._names.index(name)], dtype=np.float64)

    def _time(self, times: FloatArray, wanted: float | None) -> int:
        if wanted is None:
            return len(times) - 1
        nearest = int(np.argmin(np.abs(times - wanted)))
        if abs(times[nearest] - wanted) > _SAME_S * max(1.0, abs(wanted)):
            fact = f"has no time {wanted:g} s; the nearest is {times[nearest]:.9g} s of {times[0]:g} to {times[-1]:g} s"
            raise InputError(fact, where=str(self._path), hint="give time_s as one of its times, or leave it out")
        return nearest

    def _conductors(self, name: str, at: int, times: int, nodes: int) -> tuple[IntArray, FloatArray]:
        place = self._array(self._analysis, f"conductors{name}", "iu", 2)
        value = self._array(self._data, f"conductorData{name}", "f", 3)
        if place.shape[1] < 2:
            raise self.refused(f"conductors{name} has {place.shape[1]} columns, wanted two nodes")
        self._shape(
            f"conductorData{name}", value.shape, (times, len(place), value.shape[2]), "times, conductors, values"
        )
        ends = np.asarray(place[:, :2], dtype=np.int64) - 1
        if ((ends < 0) | (ends >= nodes)).any():
            row = int(np.flatnonzero(((ends < 0) | (ends >= nodes)).any(axis=1))[0])
            fact = f"conductors{name} has {ends[row].max() + 1} in row {row + 1}, but there are {nodes} nodes"
            raise self.refused(fact)
        values = value[at, :, 0] if len(place) else np.zeros(0)
        return ends, np.asarray(values, dtype=np.float64)

    def offset(self) -> float | None:
        """The attribute wherever the writer put it."""
        for item in (self._analysis, self._data, self._data["thermalNodesRealData"], self._analysis.file):
            for name in item.attrs:
                if name.lower() == _OFFSET:
                    value = np.asarray(item.attrs[name])
                    if value.dtype.kind not in "fiu" or value.size != 1 or not np.isfinite(value).all():
                        raise self.refused(f"attribute {name} is {value!r:.40}, wanted one number")
                    return float(value.reshape(-1)[0])
        return None

    def _group(self, parent: Any, name: str) -> Any:
        found = parent.get(name)
        if not isinstance(found, h5py.Group):
            raise self.refused(f"has no group {name}")
        return found

    def _array(self, group: Any, name: str, kinds: str, dimensions: int | None) -> AnyArray:
        found = self._dataset(group, name, kinds, dimensions)
        with reading(self._path, found.name, _HINT):
            return np.asarray(found[()])

    def _dataset(self, group: Any, name: str, kinds: str, dimensions: int | None) -> Any:
        found = group.get(name)
        if not isinstance(found, h5py.Dataset):
            raise self.refused(f"has no dataset {name} in {group.name}")
        if problem := kept_elsewhere(found):
            raise self.refused(f"{found.name} {problem}")
        if found.dtype.kind not in kinds or (dimensions is not None and found.ndim != dimensions) or not found.ndim:
            fact = f"{found.name} holds {found.dtype} in {found.ndim} dimensions"
            raise self.refused(f"{fact}, not as ESATAN-TMS writes it")
        return found

    def _shape(self, name: str, shape: tuple[int, ...], wanted: tuple[int, ...], words: str) -> None:
        if shape != wanted or 0 in shape[2:]:
            raise self.refused(f"{name} is {shape}, wanted {wanted} ({words})")

    def _words(self, values: AnyArray) -> list[str]:
        texts = [v.decode("utf-8", "replace") if isinstance(v, bytes) else str(v) for v in values.tolist()]
        return [text.strip("\0 ") for text in texts]

    def refused(self, fact: str) -> InputError:
        """The error for a file that is not as it should be."""
        return InputError(fact, where=str(self._path), hint=_HINT)


@cache
def _try(path: Path, identity: Identity) -> None:
    """Read all of it in a process of its own; `InputError` when it does not come to an end, or to a bad one."""
    trial("tedm_cli.files.tmd", path, size=identity[2], hint=_HINT)


def main() -> None:
    """Read the file that the command line names, and of its temperatures all."""
    try:
        with _opened(Path(sys.argv[1])) as file:
            file.model(None)
            rows = max(1, _BLOCK // max(1, len(file.number)))
            for start in range(0, len(file.times), rows):
                file.temperatures(slice(start, start + rows))
    except InputError:
        sys.exit(REFUSED)


if __name__ == "__main__":
    main()
