"""What a contract is made of, and the datasets and frames that several kinds of file share."""

from __future__ import annotations

from dataclasses import dataclass, field

BASIC = "Nastran basic frame"
TM_FRAME = "nominal frame of the test mass (origin at its centre, axes along its edges)"
LAYOUT = "layout frame"


@dataclass(frozen=True)
class Dataset:
    """What one dataset must be: symbolic dimensions, type, unit, meaning, frame.

    Types are `float` (64 bit), `real` (64 bit, or 32 where that changes no number), `int` (64 bit), `str`.
    `open_ended`: NaN and infinity have the meaning that `long_name` gives them; elsewhere they are never written.
    """

    dims: tuple[str, ...]
    dtype: str
    units: str | None
    long_name: str
    frame: str = ""
    optional: bool = False
    open_ended: bool = False


@dataclass(frozen=True)
class FileKind:
    """One kind of file between stages, and the subcommand that makes it."""

    name: str
    version: int
    made_by: str
    datasets: dict[str, Dataset]
    fixed_dims: dict[str, int] = field(default_factory=lambda: {"xyz": 3, "xyz_column": 3})


AREAS = {
    "/area/id": Dataset(("area",), "int", "1", "number of the thermal area (subcase id of its unit load)"),
    "/area/name": Dataset(("area",), "str", "1", "name of the thermal area"),
    "/area/group": Dataset(("area",), "str", "1", "group the thermal area belongs to"),
    "/area/shield": Dataset(("area",), "str", "1", "inside or outside of the thermal shield"),
    "/area/side": Dataset(("area",), "str", "1", "side of the plane y = 0: +y, -y or mid"),
}
GRID = {
    "/grid/id": Dataset(("node",), "int", "1", "Nastran grid id, ascending"),
    "/grid/position": Dataset(("node", "xyz"), "float", "m", "grid position", BASIC),
}
