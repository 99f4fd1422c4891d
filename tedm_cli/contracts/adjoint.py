"""adjoint.h5: what the temperature of every grid and element, and every material, does to every output."""

from __future__ import annotations

from tedm_cli.contracts.spec import (
    ACCELERATIONS,
    BASIC,
    DOFS,
    FLAG,
    AreaDatasets,
    Dataset,
    FileKind,
    Values,
)

MATERIAL_CARDS = ("MAT1", "MAT9", "MAT11")
_FOUND = "adjoint"  # absent where there is none, which /refusal explains


def _found(
    path: str, dims: tuple[str, ...], dtype: str, units: str | None, long_name: str, values: Values = Values()
) -> Dataset:
    return Dataset(path, dims, dtype, units, long_name, optional=True, values=values, group=_FOUND)


class AdjointFile(AreaDatasets, FileKind):
    """Its datasets by name; `ADJOINT` is the kind of file."""

    REFUSAL = Dataset(
        "/refusal",
        ("refusal",),
        "str",
        "1",
        "why there is no adjoint of this model, where the chain asked for one; beside it are the areas alone",
        optional=True,
    )
    ROW_LABEL = _found(
        "/row/label",
        ("row",),
        "str",
        "1",
        "outputs: rows of sensitivity.h5, then the read-outs of every set",
        Values(ends=(*ACCELERATIONS, *DOFS), unique=True),
    )
    ROW_UNIT = _found(
        "/row/unit",
        ("row",),
        "str",
        "1",
        "unit of each row by a mean temperature",
        Values(words=("m/s^2/K", "rad/s^2/K", "m/K", "rad/K")),
    )
    GRID_ID = _found("/grid/id", ("node",), "int", "1", "Nastran grid id", Values(ascending=True, least=1))
    GRID_VOLUME = _found(
        "/grid/volume",
        ("node",),
        "float",
        "m^3",
        "integral of the grid's shape functions over the elements that follow it; less than 0 at corners of some",
    )
    S = _found(
        "/s",
        ("row", "node"),
        "float",
        None,
        "sensitivity to the temperature of each grid, of all elements but those with a temperature of their own",
    )
    ELEMENT_ID = _found(
        "/element/id",
        ("element",),
        "int",
        "1",
        "shells, bars and rods, which may have temperatures of their own",
        Values(ascending=True, least=1),
    )
    ELEMENT_OWN = _found(
        "/element/own",
        ("element",),
        "int",
        "1",
        "1 where it has one in an area, and takes none from its grids; 0 where it follows them, and is in /s",
        FLAG,
    )
    ELEMENT_VOLUME = _found("/element/volume", ("element",), "float", "m^3", "volume")
    ELEMENT_MEAN = _found(
        "/element/mean",
        ("row", "element"),
        "float",
        None,
        "sensitivity to its own mean temperature, in place of that of its grids",
    )
    ELEMENT_GRADIENT = _found(
        "/element/gradient",
        ("row", "element", "plane"),
        "float",
        None,
        "sensitivity to a gradient in planes 1 and 2 of a bar; of a shell along its normal, and 0",
    )
    MAP_ELEMENT = _found(
        "/map/element_id",
        ("mapped",),
        "int",
        "1",
        "all elements, solids among them",
        Values(ascending=True, least=1),
    )
    MAP_VOLUME = _found("/map/volume", ("mapped",), "float", "m^3", "volume", Values(least=0))
    MAP_S = _found(
        "/map/s",
        ("row", "mapped"),
        "float",
        None,
        "sensitivity to 1 K of a whole element, its own temperature or all of its grids' in it; sums to 1 K everywhere",
    )
    DIRECT = _found(
        "/direct",
        ("row", "area"),
        "float",
        None,
        "part by an area that does not pass through the structure: faces of test masses that expand",
    )
    AREA_SUM = _found(
        "/area/sum", ("row", "area"), "float", None, "sum over the area, per /area/unit; with /direct it is S or N"
    )
    AREA_CANCELLATION = Dataset(
        "/area/cancellation",
        ("row", "area"),
        "float",
        "1",
        "sum of the sizes of its terms over that of their sum; infinite where they cancel, NaN where there are none",
        optional=True,
        open_ended=True,
        group=_FOUND,
    )
    AREA_GRADIENT = Dataset(
        "/area/gradient",
        ("row", "area", "xyz"),
        "float",
        None,
        "sensitivity to 1 K/m along x, y, z in the area, 0 at its centroid by volume; NaN of areas that are gradients",
        BASIC,
        True,
        open_ended=True,
        group=_FOUND,
    )
    MATERIAL_ID = _found(
        "/material/id", ("material",), "int", "1", "Nastran id of each material", Values(ascending=True, least=1)
    )
    MATERIAL_CARD = _found("/material/card", ("material",), "str", "1", "its card", Values(words=MATERIAL_CARDS))
    MATERIAL_USED_BY = _found("/material/used_by", ("material",), "str", "1", "properties of elements that name it")
    MATERIAL_EXPANSION = Dataset(
        "/material/expansion",
        ("material",),
        "float",
        "1/K",
        "coefficient of thermal expansion; NaN of those that are not the same in all directions",
        optional=True,
        open_ended=True,
        group=_FOUND,
    )
    DS_DLNE = _found(
        "/material/dS_dlnE",
        ("material", "row", "area"),
        "float",
        None,
        "change of /area/sum by the logarithm of the moduli, which grow together: the Poisson ratios stay",
    )
    DS_DLNALPHA = _found(
        "/material/dS_dlnalpha",
        ("material", "row", "area"),
        "float",
        None,
        "change by the logarithm of the expansion: what the material does of /area/sum, to which all of them sum",
    )
    DS_DALPHA = _found(
        "/material/dS_dalpha",
        ("material", "row", "area"),
        "float",
        None,
        "change by an expansion that is added to that of the material, the same in all directions",
    )
    DS_DLNRHO = _found(
        "/material/dS_dlnrho",
        ("material", "row", "area"),
        "float",
        None,
        "change by the logarithm of the density, without non-structural and concentrated mass; 0 of read-outs",
    )
    SHELL_PROPERTY_ID = _found(
        "/shell/property_id",
        ("shell",),
        "int",
        "1",
        "Nastran id of each property of shells, PSHELL",
        Values(ascending=True, least=1),
    )
    DS_DLNT = _found(
        "/shell/dS_dlnt",
        ("shell", "row", "area"),
        "float",
        None,
        "change by the logarithm of its thickness: of stiffness, thermal forces and structural mass",
    )
    CHECK_BLOCK = _found(
        "/check/block", ("row",), "str", "1", "rows whose differences are measured by the largest of them together"
    )
    CHECK_DIFFERENCE = _found(
        "/check/difference",
        ("row", "area"),
        "float",
        "1",
        "|sum over the area + direct - S or N| over the largest of its block and kind of area",
    )
    CHECK_ALLOWED = _found(
        "/check/allowed",
        ("row", "area"),
        "float",
        "1",
        "largest difference allowed: 1e-6, or what results in single precision make, where that is more",
    )
    CHECK_RESIDUAL = Dataset(
        "/check/residual",
        (),
        "float",
        "1",
        "largest relative residual of the solutions; NaN of those of another solver",
        optional=True,
        open_ended=True,
        group=_FOUND,
    )


ADJOINT = AdjointFile("adjoint", 2, "tedm build-adjoint", fixed_dims={"xyz": 3, "xyz_column": 3, "plane": 2})
