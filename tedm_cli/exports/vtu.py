"""Meshes with arrays on points and cells as .vtu files, with what VTK's arrays cannot say in files beside them.

`NAME.vtu` is VTK's XML (compressed). `NAME_arrays.csv` lists its arrays with unit, meaning and sum; `NAME_colours.json`
holds the names behind the arrays of numbers as categorical colour maps that ParaView imports.
"""

from __future__ import annotations

import itertools
import json
import re
import zlib
from base64 import b64encode
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TextIO
from xml.sax.saxutils import quoteattr

import numpy as np

from tedm_cli.arrays import AnyArray, FloatArray
from tedm_cli.exports.mesh import Cells
from tedm_cli.figures.drawing.colours import LEFT_OUT, area_colours
from tedm_cli.files.store import replacing
from tedm_cli.tables.csv_table import csv_line

_BLOCK = 1 << 15  # bytes, as VTK's own writer takes them


@dataclass(frozen=True, eq=False)
class MeshArray:
    """Numbers on all points or cells, [n] or [n, 3]. `total`: whether their sum says something."""

    name: str
    values: AnyArray
    unit: str
    meaning: str
    total: bool = False


@dataclass(frozen=True)
class Names:
    """The names behind the numbers 0, 1, ... of the array `array`, and a group of each, for its hue; -1 is none."""

    array: str
    names: Sequence[str]
    groups: Sequence[str]


def array_name(*parts: str) -> str:
    """A name of letters, digits and `_ . + -`, which needs no quoting in XML or in ParaView's calculator."""
    return re.sub(r"[^A-Za-z0-9_.+-]", "_", "_".join(parts))


def distinct(arrays: Sequence[MeshArray]) -> list[MeshArray]:
    """The same arrays; one whose name is there already gets the least number from 2 on that makes it another."""
    taken = {a.name for a in arrays}
    seen: set[str] = set()
    out = []
    for a in arrays:
        name = a.name
        if name in seen:
            name = next(new for n in itertools.count(2) if (new := f"{a.name}+{n}") not in taken)
            taken.add(name)
        seen.add(name)
        out.append(a if name == a.name else replace(a, name=name))
    return out


def write_vtu(
    path: Path,
    points: FloatArray,
    cells: Sequence[Cells],
    on_points: Sequence[MeshArray],
    on_cells: Sequence[MeshArray],
    names: Sequence[Names],
) -> list[Path]:
    """The files written. Arrays have distinct names; those on cells are in the order of `cells`, block after block.

    Parameters
    ----------
    points : [N, 3], m.
    """
    table, colours = (path.with_name(path.stem + end) for end in ("_arrays.csv", "_colours.json"))
    with replacing(path) as temporary, open(temporary, "w", encoding="ascii", newline="\n") as stream:
        _write_mesh(stream, points, cells, on_points, on_cells)
    with replacing(table) as temporary:
        temporary.write_text(_table(on_points, on_cells), encoding="utf-8", newline="\n")
    with replacing(colours) as temporary:
        temporary.write_text(json.dumps([_preset(n) for n in names], indent=1) + "\n", encoding="utf-8", newline="\n")
    return [path, table, colours]


def _write_mesh(
    stream: TextIO,
    points: FloatArray,
    cells: Sequence[Cells],
    on_points: Sequence[MeshArray],
    on_cells: Sequence[MeshArray],
) -> None:
    """One array after the other: no more is held than the array that is being written."""
    count = np.concatenate([np.zeros(0, dtype=np.int64), *(np.full(len(c.nodes), c.nodes.shape[1]) for c in cells)])
    stream.write(
        '<?xml version="1.0"?>\n<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian"'
        ' header_type="UInt64" compressor="vtkZLibDataCompressor">\n<UnstructuredGrid>\n'
        f'<Piece NumberOfPoints="{len(points)}" NumberOfCells="{len(count)}">\n<Points>\n'
    )
    _write_array(stream, "Points", points)
    stream.write("</Points>\n<Cells>\n")
    _write_array(
        stream, "connectivity", np.concatenate([np.zeros(0, dtype=np.int64), *(c.nodes.ravel() for c in cells)])
    )
    _write_array(stream, "offsets", np.cumsum(count))
    _write_array(stream, "types", np.repeat([c.kind for c in cells], [len(c.nodes) for c in cells]).astype(np.uint8))
    stream.write("</Cells>\n")
    for section, arrays in (("PointData", on_points), ("CellData", on_cells)):
        stream.write(f"<{section}>\n")
        for array in arrays:
            _write_array(stream, array.name, array.values)
        stream.write(f"</{section}>\n")
    stream.write("</Piece>\n</UnstructuredGrid>\n</VTKFile>\n")


def _write_array(stream: TextIO, name: str, values: AnyArray) -> None:
    """A `DataArray` in base64: numbers of blocks and bytes, then blocks compressed by themselves (VTK's XML format)."""
    kind = {"f": ("Float64", "<f8"), "i": ("Int64", "<i8"), "u": ("UInt8", "u1")}[values.dtype.kind]
    raw = np.ascontiguousarray(values, dtype=kind[1]).tobytes()
    blocks = [zlib.compress(raw[start : start + _BLOCK]) for start in range(0, len(raw), _BLOCK)]
    header = np.array([len(blocks), _BLOCK, len(raw) % _BLOCK, *map(len, blocks)], dtype="<u8")
    components = "" if values.ndim == 1 else f' NumberOfComponents="{values.shape[1]}"'
    stream.write(f'<DataArray type="{kind[0]}" Name={quoteattr(name)}{components} format="binary">\n')
    stream.write(b64encode(header.tobytes()).decode("ascii"))
    stream.write(b64encode(b"".join(blocks)).decode("ascii"))
    stream.write("\n</DataArray>\n")


def _table(on_points: Sequence[MeshArray], on_cells: Sequence[MeshArray]) -> str:
    lines: list[list[object]] = [["array", "on", "components", "unit", "meaning", "sum"]]
    for where, arrays in (("points", on_points), ("cells", on_cells)):
        for a in arrays:
            components = 1 if a.values.ndim == 1 else a.values.shape[1]
            lines.append([a.name, where, components, a.unit, a.meaning, repr(float(a.values.sum())) if a.total else ""])
    return "".join(map(csv_line, lines))


def _preset(names: Names) -> dict[str, Any]:
    """A categorical colour map of ParaView: values and their names in turns, and their colours."""
    colours = [LEFT_OUT, *area_colours(names.groups, set()).tolist()]
    pairs = [(-1, "none"), *enumerate(names.names)]
    return {
        "Name": f"tedm {names.array}",
        "Annotations": [text for value, name in pairs for text in (str(value), name)],
        "IndexedColors": [round(float(c), 4) for colour in colours for c in colour],
        "NanColor": [0.5, 0.5, 0.5],
    }
