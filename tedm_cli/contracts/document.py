"""The contracts as the text of docs/files.md."""

from __future__ import annotations

from collections.abc import Iterable

from tedm_cli.contracts.spec import FileKind

_PREFACE = """\
# Files between the stages

Printed from `tedm_cli/contracts/` by `python -m tedm_cli.contracts > docs/files.md`.

All files are HDF5 with netCDF-4 dimension scales: they open in h5py, MATLAB (`h5read`) and, group by group, in
`xarray.open_dataset(file, group="/dc", engine="h5netcdf")`. Every dataset MUST have the attributes `units` and
`long_name`; vectors MUST name their `frame`. Arrays over grids are chunked along the grids.

`float` and `int` are of 64 bits. `real` is float32 where every number is exact in it (an OP2 in single precision, grids
in the basic frame, loads of 1 K) and float64 otherwise: turn it into double precision before you compute with it.

Numbers are finite: a writer MUST refuse NaN and infinity, except in a dataset whose meaning says what they stand for.

Root attributes: `schema` (`tedm.<kind>`), `schema_version`, `tedm_version`, `command_line`, versions of Python and of
the libraries. `/provenance` holds the configurations verbatim and the SHA-256 of every input; paths are relative to the
file. There is no time stamp: the same inputs MUST give the same bytes. A reader MUST refuse a file of another kind or
version, and writers replace the old file only when the new one is complete.

Accelerations are force over mass and torque over moment of inertia, component by component; stiffnesses are their
derivatives by motion of the test mass, normalised the same way. Signs are in [method.md](method.md).
"""


def document(kinds: Iterable[FileKind]) -> str:
    """The tables as the text of docs/files.md."""
    lines = _PREFACE.splitlines()
    for kind in kinds:
        lines += ["", f"## {kind.name}", "", f"Version {kind.version}, made by `{kind.made_by}`.", ""]
        lines += ["| dataset | dimensions | type | unit | meaning |", "|---|---|---|---|---|"]
        for path, d in kind.datasets.items():
            dims = ", ".join(f"{n}={kind.fixed_dims[n]}" if n in kind.fixed_dims else n for n in d.dims) or "scalar"
            unit = "varies" if d.units is None else d.units
            meaning = d.long_name + (f"; {d.frame}" if d.frame else "") + (" (optional)" if d.optional else "")
            lines.append(f"| `{path}` | {dims} | {d.dtype} | {unit} | {meaning} |")
    return "\n".join(lines) + "\n"
