"""Thermal models of ESATAN-TMS: `.TMD` files are HDF5, of the layout that public readers (pycanha and others) know.

In the group AnalysisSet1, whose attribute `TAbs` is the offset that makes kelvin of its temperatures: `thermalNodes`
[n, ...] (numbers of nodes first), `conductorsGL` and `conductorsGR` [m, 2] (places of nodes, from 1), names of
quantities in `thermalNodesRealAttributes` and `thermalNodesStringAttributes`; in its group DataGroup1: `times` [t],
`thermalNodesRealData` and `thermalNodesStringData` [t, n, quantity], `conductorDataGL` and `conductorDataGR` [t, m, 1].
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from tedm_cli.arrays import AnyArray, FloatArray, IntArray
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
_SAME_S = 1e-6  # seconds


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


def read_tmd(path: Path, time_s: float | None) -> TmdModel:
    """The model at `time_s`, or at the last of its times.

    Raises
    ------
    InputError : missing, not HDF5, damaged, with data in other files, of another layout, or without that time.
    """
    require_regular_file(path)
    try:
        _try(path, identity_of(path))
    except FileNotFoundError:
        raise InputError("no such file", where=str(path)) from None
    except OSError as exc:
        raise InputError(f"cannot be read ({exc.strerror})", where=str(path)) from None
    return _read(path, time_s)


def _read(path: Path, time_s: float | None) -> TmdModel:
    try:
        opened = h5py.File(path, "r")
    except OSError:
        raise InputError("not a readable HDF5 file (truncated or damaged)", where=str(path), hint=_HINT) from None
    with opened as file, reading(path, hint=_HINT):
        for problem in links_elsewhere(file, soft=True):
            raise InputError(problem, where=str(path), hint="copy the data into the file itself")
        return _Tmd(file, path).model(time_s)


class _Tmd:
    """An open file."""

    def __init__(self, file: Any, path: Path) -> None:
        self._path = path
        self._analysis = self._group(file, _ANALYSIS)
        self._data = self._group(self._analysis if _DATA in self._analysis else file, _DATA)

    def model(self, time_s: float | None) -> TmdModel:
        numbers = self._array(self._analysis, "thermalNodes", "iu", None)
        number = np.asarray(numbers.reshape(len(numbers), -1)[:, 0], dtype=np.int64)
        times = np.asarray(self._array(self._data, "times", "f", 1), dtype=np.float64)
        at = self._time(times, time_s)
        names = self._words(self._array(self._analysis, "thermalNodesRealAttributes", "SO", 1))
        real = self._array(self._data, "thermalNodesRealData", "f", 3)
        self._shape("thermalNodesRealData", real, (len(times), len(number), len(names)), "times, nodes, quantities")
        words = self._array(self._data, "thermalNodesStringData", "SO", 3)
        self._shape("thermalNodesStringData", words, (len(times), len(number), words.shape[2]), "times, nodes, words")
        if lost := [name for name in ("T", "C") if name not in names]:
            held = ", ".join(names[:20])
            raise self._refused(f"thermalNodesRealAttributes has no quantity {lost[0]}; it has {held}")

        def quantity(name: str) -> FloatArray:
            return np.asarray(real[at, :, names.index(name)], dtype=np.float64)

        power = sum((quantity(q) for q in _POWERS if q in names), np.zeros(len(number)))
        kind = [word[:1].upper() for word in self._words(words[at, :, 0])]
        conductors = [self._conductors(name, at, len(times), len(number)) for name in ("GL", "GR")]
        return TmdModel(
            number, kind, quantity("T"), quantity("C"), power, self._offset(), float(times[at]), *conductors
        )

    def _time(self, times: FloatArray, wanted: float | None) -> int:
        if not len(times):
            raise self._refused("holds no time, so no temperatures")
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
            raise self._refused(f"conductors{name} has {place.shape[1]} columns, wanted two nodes")
        self._shape(f"conductorData{name}", value, (times, len(place), value.shape[2]), "times, conductors, values")
        ends = np.asarray(place[:, :2], dtype=np.int64) - 1
        if ((ends < 0) | (ends >= nodes)).any():
            row = int(np.flatnonzero(((ends < 0) | (ends >= nodes)).any(axis=1))[0])
            fact = f"conductors{name} has {ends[row].max() + 1} in row {row + 1}, but there are {nodes} nodes"
            raise self._refused(fact)
        values = value[at, :, 0] if len(place) else np.zeros(0)
        return ends, np.asarray(values, dtype=np.float64)

    def _offset(self) -> float | None:
        """The attribute wherever the writer put it."""
        for item in (self._analysis, self._data, self._data["thermalNodesRealData"], self._analysis.file):
            for name in item.attrs:
                if name.lower() == _OFFSET:
                    value = np.asarray(item.attrs[name])
                    if value.dtype.kind not in "fiu" or value.size != 1 or not np.isfinite(value).all():
                        raise self._refused(f"attribute {name} is {value!r:.40}, wanted one number")
                    return float(value.reshape(-1)[0])
        return None

    def _group(self, parent: Any, name: str) -> Any:
        found = parent.get(name)
        if not isinstance(found, h5py.Group):
            raise self._refused(f"has no group {name}")
        return found

    def _array(self, group: Any, name: str, kinds: str, dimensions: int | None) -> AnyArray:
        found = group.get(name)
        if not isinstance(found, h5py.Dataset):
            raise self._refused(f"has no dataset {name} in {group.name}")
        if problem := kept_elsewhere(found):
            raise self._refused(f"{found.name} {problem}")
        if found.dtype.kind not in kinds or (dimensions is not None and found.ndim != dimensions) or not found.ndim:
            fact = f"{found.name} holds {found.dtype} in {found.ndim} dimensions"
            raise self._refused(f"{fact}, not as ESATAN-TMS writes it")
        with reading(self._path, found.name, _HINT):
            return np.asarray(found[()])

    def _shape(self, name: str, value: AnyArray, wanted: tuple[int, ...], words: str) -> None:
        if value.shape != wanted or 0 in value.shape[2:]:
            raise self._refused(f"{name} is {value.shape}, wanted {wanted} ({words})")

    def _words(self, values: AnyArray) -> list[str]:
        texts = [v.decode("utf-8", "replace") if isinstance(v, bytes) else str(v) for v in values.tolist()]
        return [text.strip("\0 ") for text in texts]

    def _refused(self, fact: str) -> InputError:
        return InputError(fact, where=str(self._path), hint=_HINT)


@cache
def _try(path: Path, identity: Identity) -> None:
    """Read all of it in a process of its own; `InputError` when it does not come to an end, or to a bad one."""
    trial("tedm_cli.files.tmd", path, size=identity[2], hint=_HINT)


def main() -> None:
    """Read the file that the command line names."""
    try:
        _read(Path(sys.argv[1]), None)
    except InputError:
        sys.exit(REFUSED)


if __name__ == "__main__":
    main()
