"""What a contract is made of, and the datasets and frames that several kinds of file share."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Any

BASIC = "Nastran basic frame"
TM_FRAME = "nominal frame of the test mass (origin at its centre, axes along its edges)"
LAYOUT = "layout frame"


@dataclass(frozen=True)
class Values:
    """What the values of a dataset must be, besides of their type.

    Parameters
    ----------
    words : the strings there may be.
    of : the strings are among those of this dataset, if the file has it; with `ends`, they begin with one of them.
    ends : the strings end with `_` and one of these.
    unique : names: none is empty and none is there twice.
    parts_of : the strings begin with the names of this dataset in their order, as many with each, and go on with `_`.
    rows_of : the integers are rows along this dimension.
    none : -1 may stand for no row, and an empty string for no name.
    starts_in : the integers are where each part begins along this dimension, and the end of the last.
    ascending : each integer is larger than the one before.
    flag : the integers are 0 or 1.
    least : the least integer there may be.
    """

    words: tuple[str, ...] = ()
    of: str = ""
    ends: tuple[str, ...] = ()
    unique: bool = False
    parts_of: str = ""
    rows_of: str = ""
    none: bool = False
    starts_in: str = ""
    ascending: bool = False
    flag: bool = False
    least: int | None = None

    def rules(self) -> list[str]:
        """The same in words."""
        empty = " or nothing" if self.none else ""
        return [
            *([f"one of {', '.join(w or 'nothing' for w in self.words)}"] if self.words else []),
            *([f"{'begins with one of' if self.ends else 'among'} `{self.of}`{empty}"] if self.of else []),
            *([f"ends with {', '.join(self.ends)}"] if self.ends else []),
            *(["no two the same"] if self.unique else []),
            *([f"as many for each of `{self.parts_of}`, in their order"] if self.parts_of else []),
            *([f"rows along {self.rows_of}" + (" or -1" if self.none else "")] if self.rows_of else []),
            *([f"from 0 to the length of {self.starts_in}, never falling"] if self.starts_in else []),
            *(["ascending"] if self.ascending else []),
            *(["0 or 1"] if self.flag else []),
            *([f"at least {self.least}"] if self.least is not None else []),
        ]


NAMES = Values(unique=True)
FLAG = Values(flag=True)
ID = Values(least=1)
COUNT = Values(least=0)
KINDS_OF_AREA = ("mean", "gradient", "gradient_x", "gradient_y", "gradient_z")
UNITS_OF_AREA = ("K", "K/m")
PER_AREA = "m/K; m/(K/m) of gradients"
ON_GRIDS = "displacements of grids"  # absent where results were reduced without keeping them
TURN_PER_AREA = "rad/K; rad/(K/m) of gradients"
MOTIONS = ("ux", "uy", "uz", "rx", "ry", "rz")
DOFS = ("x", "y", "z", "theta", "eta", "phi")
ACCELERATIONS = ("a_x", "a_y", "a_z", "omegadot_x", "omegadot_y", "omegadot_z")
QUANTITIES = Values(words=("acceleration", "angular_acceleration", "displacement", "angle"))


#: What labels dimensions where no rule finds it (`FileKind.label_of`): the words themselves, or a dataset.
LABELS: dict[str, str | tuple[str, ...]] = {
    "xyz": ("x", "y", "z"),
    "band_edge": ("low", "high"),
    "factor": ("configured", "one"),
    "estimate": ("probability", "error", "low", "high"),
    "probability": "/uncertainty/probability",
    "frequency": "/frequency",
    "order": "/filter_sensitivity/order",
    "corner": "/filter_sensitivity/corner",
    "bin": "/realisation/frequency",
    "sample": "/time",
    "loop_frequency": "/loop/frequency",
    "body": "/label/body_coordinate",
    "tm_motion": "/label/tm_motion",
}


@dataclass(frozen=True, eq=False, repr=False)
class Dataset(str):
    """The path of a dataset in its file, and what it must be: symbolic dimensions, type, unit, meaning, frame, values.

    Types are `float` (64 bit), `real` (64 bit, or 32 where that changes no number), `complex` (two of 64 bit),
    `int` (64 bit), `str`.
    `open_ended`: NaN and infinity have the meaning that `long_name` gives them; elsewhere they are never written.

    A path with a name in braces (`/psd/{output}`) stands for a family of datasets, one for each name.

    `group`: optional datasets of one group come together; the first part of the path, unless another is given.

    `view_of`: a kind of file among the inputs, and a dataset in it: this one MAY be a virtual dataset onto that, whole,
    in the file of that kind's name beside its own. So what both hold is on the disk once.
    """

    path: str
    dims: tuple[str, ...]
    dtype: str
    units: str | None
    long_name: str
    frame: str = ""
    optional: bool = False
    values: Values = Values()
    open_ended: bool = False
    group: str = ""
    view_of: tuple[str, str] | None = None

    def __new__(cls, path: str, *_: Any, **__: Any) -> Dataset:
        return super().__new__(cls, path)

    @property
    def comes_with(self) -> str:
        """The group of optional datasets that this one belongs to."""
        return self.group or self.path.split("/")[1]

    def of(self, *names: str) -> str:
        """The path of one dataset of a family: PSD.of("TM1_a_x") is `/psd/TM1_a_x`."""
        given = iter(names)
        return re.sub(r"{\w+}", lambda _: next(given), self)


@dataclass(frozen=True)
class FileKind:
    """One kind of file between stages, and the subcommand that makes it.

    Its datasets are the attributes of its class, those of its bases first; `datasets` has them by path.

    `fixed_dims` are lengths that are always the same. `derived_dims` gives others as (dimension, factor, addend).
    `families` names the dataset with the names that stand for the braces in the paths of others: a family has one
    dataset for each, or, where it is optional, for some. The optional datasets of a group come together.
    """

    name: str
    version: int
    made_by: str
    datasets: dict[str, Dataset] = field(default_factory=dict)
    fixed_dims: dict[str, int] = field(default_factory=lambda: {"xyz": 3, "xyz_column": 3})
    derived_dims: dict[str, tuple[str, int, int]] = field(default_factory=dict)
    families: dict[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for owner in reversed(type(self).__mro__):
            self.datasets.update({d: d for d in vars(owner).values() if isinstance(d, Dataset)})

    def label_of(self, dim: str) -> str | tuple[str, ...] | None:
        """What tells the places along a dimension apart: the path of a dataset, or the words themselves; None: nothing.

        What `LABELS` says; else the dataset of names of which no two are the same; else that of numbers that ascend,
        such as ids of grids. `area_column` has the labels of `area`. A file may lack the dataset where it is optional.
        """
        dim = dim.removesuffix("_column")
        known = LABELS.get(dim)
        if known is not None and (isinstance(known, tuple) or known in self.datasets):
            return known
        along = [d for path, d in self.datasets.items() if d.dims == (dim,) and "{" not in path]
        names = [d for d in along if d.dtype == "str" and d.values.unique]
        ids = [d for d in along if d.dtype == "int" and d.values.ascending and not d.values.rows_of]
        return next((d.path for d in (*names, *ids)), None)

    def length_law(self, dim: str) -> str:
        """How a derived dimension follows from another."""
        base, factor, addend = self.derived_dims[dim]
        return f"{factor} x {base}" if factor != 1 else f"{base} + {addend}" if addend else base


class AreaDatasets:
    """The thermal areas, in the order of every array over areas."""

    AREA_ID = Dataset(
        "/area/id",
        ("area",),
        "int",
        "1",
        "number of the thermal area (subcase id of its unit load)",
        values=Values(unique=True, least=1),
    )
    AREA_NAME = Dataset("/area/name", ("area",), "str", "1", "name of the thermal area", values=NAMES)
    AREA_GROUP = Dataset("/area/group", ("area",), "str", "1", "group the thermal area belongs to")
    AREA_SHIELD = Dataset(
        "/area/shield", ("area",), "str", "1", "side of the thermal shield", values=Values(words=("inside", "outside"))
    )
    AREA_SIDE = Dataset(
        "/area/side", ("area",), "str", "1", "side of the symmetry plane", values=Values(words=("+y", "-y", "mid"))
    )
    AREA_KIND = Dataset(
        "/area/kind",
        ("area",),
        "str",
        "1",
        "its unit load: a mean temperature, or a gradient through its shells and bars at an unchanged mean; in cases"
        " also gradients within areas along x, y, z, without one",
        values=Values(words=KINDS_OF_AREA),
    )
    AREA_UNIT = Dataset(
        "/area/unit",
        ("area",),
        "str",
        "1",
        "unit of the area's temperature: K of a mean, K/m of a gradient; columns of matrices are per this unit",
        values=Values(words=UNITS_OF_AREA),
    )


class AreaPlaces:
    """Where the thermal areas are, and the symmetry plane that gives them sides and mirror images."""

    AREA_CENTROID = Dataset(
        "/area/centroid",
        ("area", "xyz"),
        "float",
        "m",
        "mean position of the area's grids; of elements, of their centres",
        BASIC,
    )
    PLANE_POINT = Dataset("/symmetry_plane/point", ("xyz",), "float", "m", "a point of the symmetry plane", BASIC)
    PLANE_NORMAL = Dataset(
        "/symmetry_plane/normal", ("xyz",), "float", "1", "its unit normal, towards the side +y", BASIC
    )
    PLANE_ORIGIN = Dataset(
        "/symmetry_plane/origin",
        (),
        "str",
        "1",
        "where it is from: the model's configuration, the frame of the optical layout, or the basic frame",
        values=Values(words=("configured", "layout", "basic")),
    )


class GridIds:
    """The grids of the model."""

    GRID_ID = Dataset("/grid/id", ("node",), "int", "1", "Nastran grid id", values=Values(ascending=True, least=1))


class GridDatasets(GridIds):
    """The grids with their positions."""

    GRID_POSITION = Dataset("/grid/position", ("node", "xyz"), "float", "m", "grid position", BASIC)
