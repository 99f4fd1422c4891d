"""The contracts as the text of docs/reference/files.md."""

from __future__ import annotations

from collections.abc import Iterable

from tedm_cli.contracts.spec import FileKind

_PREFACE = """\
# Files between the stages

All files are HDF5 with netCDF-4 dimension scales: they open in h5py, MATLAB (`h5read`) and, group by group, in
`xarray.open_dataset(file, group="/dc", engine="h5netcdf")`. Every dataset MUST have the attributes `units` and
`long_name`; vectors MUST name their `frame`. Arrays over grids are chunked along the grids.

The dimension scales contain labels. In every group, `area` has the names of the areas, `output` those of the outputs,
`frequency` the frequencies, `node` the ids of the grids, `xyz` the axes. So `.sel(area="STRUT_5")` works. If the root
has a group with that name, the scale has the name of its label: `/S` has the dimensions `row_label` and `area_name`. A
dimension without labels is called `n_rank`. A file MAY lack scales. If it has them, they MUST be equal to the dataset
that they copy (`/area/name`). They are not in the tables. `import tedm` reads a file as one Dataset
([Python library](library.md)).

The last line of a file is its seal: `tedm sha256` and the SHA-256 of all bytes before it (`head -c -78 FILE |
sha256sum` prints the same). It is after the end of the HDF5 data; other programs ignore it. A reader MUST compare it
before anything else, because a flipped bit in a string is not noticed otherwise, and some damage makes the HDF5
library loop for ever. A file without a seal is refused. h5py removes the seal when it opens a file for writing. If
another program has written or changed a file, seal it with `python -m tedm_cli.files.seal FILE`. The sum takes 0.6 s
per GB. Each command computes it once, also for the provenance of its output.

Arrays are stored in chunks with a Fletcher checksum each, scalars in object headers, which have a checksum. `str` is
UTF-8 of fixed length, filled with zeros, and therefore covered by both (`asstr()` in h5py). Text attributes are
covered by the seal only. The values MUST be as the tables say. All parts MUST be in the file itself: soft and external
links, virtual datasets and external storage are refused, and so are arrays that were not completely written.

There is one exception. [D] of loads of 1 K is the displacements themselves. It is then a virtual dataset onto
unit_loads.h5 in the same folder: the numbers are on the disk once, and h5py, xarray and MATLAB still find them in
distortion.h5. Copy and move the two files together. Without unit_loads.h5 beside it, HDF5 itself reads zeros and says
nothing. So a reader MUST take the numbers from unit_loads.h5, and only if its SHA-256 is the one in `/provenance`. Who
writes into this dataset with another program writes into unit_loads.h5, which then no longer fits its seal.

If a path ends with a name in braces, there is one dataset for each name; if such datasets are optional, for some
names. The optional datasets of a group are all present or all absent; those of the optical elements in distortion.h5
are one group.

Users' own HDF5 files have no seal. They are first read in a separate process, which may take a minute and 0.1 s per
MB. So a file that makes the HDF5 library hang or crash is an error. External links, virtual datasets and external
storage are refused in them as well.

`float` and `int` have 64 bits. `real` is float32 if every number is exact in it (results in single precision, grids in
the basic frame, loads of 1 K), and float64 otherwise: convert it to double precision before you compute with it.
`complex` is two float64, which HDF5 has as a compound of `r` and `i`: h5py and xarray make complex numbers of it.

Numbers are finite: a writer MUST refuse NaN and infinity, except in a dataset whose meaning says what they stand for.

Root attributes: `schema` (`tedm.<kind>`), `schema_version`, `tedm_version`, `command_line`, versions of Python and of
the libraries. `/provenance` has the full text of the configurations and the SHA-256 of every input; paths are relative
to the file. There is no time stamp: the same inputs MUST give the same bytes. A reader MUST refuse a file of another
kind or version. A writer replaces the old file only when the new one is complete.

Accelerations are force over mass and torque over moment of inertia, component by component; stiffnesses are their
derivatives by motion of the test mass, normalised the same way. Signs are in [Method](../explanation/method.md).
"""
_ORIGIN = "<!-- Printed from `tedm_cli/contracts/` by `python -m tedm_cli.contracts > docs/reference/files.md`. -->"


def document(kinds: Iterable[FileKind]) -> str:
    """The tables as the text of docs/reference/files.md."""
    lines = _PREFACE.splitlines()
    for kind in kinds:
        lines += ["", f"## {kind.name}", "", f"Version {kind.version}, made by `{kind.made_by}`.", ""]
        laws = [f"{dim} is {law}" for dim in kind.derived_dims if (law := kind.length_law(dim))]
        names = [f"`{{{name}}}` is among `{path}`" for name, path in kind.families.items()]
        lines += [f"{sentence}." for sentence in ("; ".join(laws), "; ".join(names)) if sentence]
        lines += [""] * bool(laws or names)
        lines += ["| dataset | dimensions | type | unit | meaning |", "|---|---|---|---|---|"]
        for path, d in kind.datasets.items():
            dims = ", ".join(f"{n}={kind.fixed_dims[n]}" if n in kind.fixed_dims else n for n in d.dims) or "scalar"
            unit = "varies" if d.units is None else d.units
            view = [f"may be a virtual dataset onto `{d.view_of[1]}` of {d.view_of[0]}.h5"] if d.view_of else []
            meaning = "; ".join([d.long_name, *([d.frame] if d.frame else []), *d.values.rules(), *view])
            lines.append(f"| `{path}` | {dims} | {d.dtype} | {unit} | {meaning}{' (optional)' if d.optional else ''} |")
    return "\n".join([*lines, "", _ORIGIN]) + "\n"
