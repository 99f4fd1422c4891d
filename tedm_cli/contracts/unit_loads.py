"""unit_loads.h5: displacements under the unit loads, with the model's geometry and mass."""

from __future__ import annotations

from tedm_cli.contracts.spec import (
    BASIC,
    COUNT,
    ID,
    NAMES,
    ON_GRIDS,
    AreaDatasets,
    AreaPlaces,
    Dataset,
    FileKind,
    GridDatasets,
    Values,
)

ELEMENTS = (
    *("CTETRA", "CPYRAM", "CPENTA", "CHEXA"),
    *("CTRIA3", "CTRIA6", "CTRIAR", "CQUAD4", "CQUAD8", "CQUADR", "CSHEAR"),
    *("CBAR", "CBEAM", "CROD", "CONROD", "CTUBE", "CBUSH"),
    *("CELAS1", "CELAS2", "CELAS3", "CELAS4", "CDAMP1", "CDAMP2", "CDAMP3", "CDAMP4", "CDAMP5", "CVISC", "CGAP"),
    *("CBUSH1D", "CBUSH2D", "CFAST", "CWELD", "CSEAM", "GENEL", "PLOTEL", "CHBDYG", "CHBDYE", "CHBDYP"),
)
"""Cards of elements that a file may hold: those with mass, and those that have none."""


class UnitLoadsFile(AreaPlaces, AreaDatasets, GridDatasets, FileKind):
    """Its datasets by name; `UNIT_LOADS` is the kind of file."""

    AREA_LOAD_K = Dataset(
        "/area/load_K",
        ("area",),
        "float",
        "K; K/m of gradients",
        "temperature step applied to the area in its unit load, in the unit of /area/unit",
    )
    AREA_MASS = Dataset(
        "/area/mass",
        ("area",),
        "float",
        "kg",
        "mass of the area's elements, or lumped mass of its grids; for a gradient not part of any sum",
    )
    AREA_MEAN_STEP = Dataset(
        "/area/mean_step",
        ("area",),
        "float",
        "1",
        "share of the step that the area's own elements receive, weighted by volume; NaN of gradients",
        optional=True,
        open_ended=True,
        group="mean step",
    )
    PLANE_LAYOUT = Dataset(
        "/symmetry_plane/layout",
        (),
        "str",
        "1",
        "path of the layout that defines the symmetry plane, relative to the folder of this file; empty: no layout",
    )
    AREA_NODE_OFFSET = Dataset(
        "/area/node_offset",
        ("area_edge",),
        "int",
        "1",
        "start of each area in node_index, and its end; an area of elements may have no grids of its own",
        values=Values(starts_in="area_member"),
    )
    AREA_NODE_INDEX = Dataset(
        "/area/node_index",
        ("area_member",),
        "int",
        "1",
        "rows of /grid that belong to each area",
        values=Values(rows_of="node"),
    )
    AREA_ELEMENT_OFFSET = Dataset(
        "/area/element_offset",
        ("area_edge",),
        "int",
        "1",
        "start of each area in element_index, and its end; empty of areas whose grids alone are warmed",
        values=Values(starts_in="area_element_member"),
    )
    AREA_ELEMENT_INDEX = Dataset(
        "/area/element_index",
        ("area_element_member",),
        "int",
        "1",
        "rows of /element that the area's unit load names by cards of their own",
        values=Values(rows_of="element"),
    )
    TRANSLATION = Dataset(
        "/translation",
        ("area", "node", "xyz"),
        "real",
        "m",
        "translation under each unit load; not kept by `tedm merge`",
        BASIC,
        True,
        group=ON_GRIDS,
    )
    ROTATION = Dataset(
        "/rotation",
        ("area", "node", "xyz"),
        "real",
        "rad",
        "rotation under each unit load",
        BASIC,
        True,
        group=ON_GRIDS,
    )
    UNIFORM_TRANSLATION = Dataset(
        "/uniform/translation",
        ("node", "xyz"),
        "real",
        "m",
        "translation when all mean areas are loaded",
        BASIC,
        True,
    )
    UNIFORM_ROTATION = Dataset(
        "/uniform/rotation",
        ("node", "xyz"),
        "real",
        "rad",
        "rotation when all mean areas are loaded",
        BASIC,
        True,
    )
    UNIFORM_LOAD_K = Dataset("/uniform/load_K", (), "float", "K", "temperature step of the uniform load", optional=True)
    RESULTS_PRECISION = Dataset(
        "/results/precision",
        (),
        "str",
        "1",
        "precision of the solver's results, the coarser if they differ; it limits the residual of the superposition",
        values=Values(words=("single", "double")),
    )
    ELEMENT_ID = Dataset("/element/id", ("element",), "int", "1", "Nastran element id", values=ID)
    ELEMENT_TYPE = Dataset(
        "/element/type", ("element",), "str", "1", "Nastran card name", values=Values(words=ELEMENTS)
    )
    ELEMENT_PROPERTY_ID = Dataset(
        "/element/property_id", ("element",), "int", "1", "Nastran property id, 0 for none", values=COUNT
    )
    ELEMENT_NODE_OFFSET = Dataset(
        "/element/node_offset",
        ("element_edge",),
        "int",
        "1",
        "start of each element in node_index, and its end",
        values=Values(starts_in="element_member"),
    )
    ELEMENT_NODE_INDEX = Dataset(
        "/element/node_index",
        ("element_member",),
        "int",
        "1",
        "rows of /grid, in Nastran's order; only the corners if a midside node is missing",
        values=Values(rows_of="node"),
    )
    ELEMENT_LEVER = Dataset(
        "/element/lever",
        ("element_member", "xyz"),
        "float",
        "m",
        "offset of the element's mass from each of its nodes",
        BASIC,
    )
    ELEMENT_WEIGHT = Dataset(
        "/element/weight",
        ("element_member",),
        "float",
        "1",
        "density of the element's mass at each node over the mean of its nodes",
    )
    ELEMENT_MASS = Dataset("/element/mass", ("element",), "float", "kg", "element mass with its non-structural mass")
    ELEMENT_DENSITY = Dataset(
        "/element/density",
        ("element",),
        "float",
        "kg/m^3",
        "material density; NaN of springs, laminates and others without a single one",
        open_ended=True,
    )
    ELEMENT_EXPANSION = Dataset(
        "/element/expansion",
        ("element",),
        "float",
        "1/K",
        "coefficient of thermal expansion; NaN of springs, laminates, anisotropic materials, which have no single one",
        open_ended=True,
    )
    ELEMENT_SECTION = Dataset(
        "/element/section",
        ("element",),
        "float",
        "m or m^2",
        "thickness of plates, cross-section area of line elements, 0 for solids",
    )
    MASS_LUMPED = Dataset(
        "/mass/lumped", ("node",), "float", "kg", "element mass shared equally to its nodes, plus concentrated masses"
    )
    MASS_CONCENTRATED = Dataset("/mass/concentrated", ("concentrated",), "float", "kg", "concentrated masses")
    MASS_CONCENTRATED_CARD = Dataset(
        "/mass/concentrated_card",
        ("concentrated",),
        "str",
        "1",
        "Nastran card; CMASS for three equal scalar masses",
        values=Values(words=("CONM1", "CONM2", "CMASS")),
    )
    MASS_CONCENTRATED_ID = Dataset(
        "/mass/concentrated_id", ("concentrated",), "int", "1", "Nastran id of each concentrated mass", values=ID
    )
    MASS_CONCENTRATED_NODE = Dataset(
        "/mass/concentrated_node",
        ("concentrated",),
        "int",
        "1",
        "row of /grid of each concentrated mass",
        values=Values(rows_of="node"),
    )
    MASS_CONCENTRATED_LEVER = Dataset(
        "/mass/concentrated_lever",
        ("concentrated", "xyz"),
        "float",
        "m",
        "offset of each concentrated mass from its grid",
        BASIC,
    )
    TIE_BLOCK = Dataset(
        "/tie/block", ("tie",), "str", "1", "compensation mass that follows grids of the structure", values=NAMES
    )
    TIE_TO = Dataset("/tie/to", ("tie",), "str", "1", "what the configuration ties it to: grids, or sets of the deck")
    TIE_NODE_OFFSET = Dataset(
        "/tie/node_offset",
        ("tie_edge",),
        "int",
        "1",
        "start of each tied block in node_index, and its end",
        values=Values(starts_in="tie_member"),
    )
    TIE_NODE_INDEX = Dataset(
        "/tie/node_index",
        ("tie_member",),
        "int",
        "1",
        "rows of /grid that each tied block follows",
        values=Values(rows_of="node"),
    )
    MASS_TOTAL = Dataset("/mass/total", (), "float", "kg", "mass of the model")
    MASS_CENTRE_OF_GRAVITY = Dataset(
        "/mass/centre_of_gravity",
        ("xyz",),
        "float",
        "m",
        "centre of gravity of the masses as they are spread over the elements",
        BASIC,
    )
    MASS_INERTIA = Dataset(
        "/mass/inertia",
        ("xyz", "xyz_column"),
        "float",
        "kg m^2",
        "inertia about the centre of gravity (plates as surfaces)",
        BASIC,
    )


UNIT_LOADS = UnitLoadsFile(
    "unit_loads",
    7,
    "tedm ingest",
    derived_dims={"area_edge": ("area", 1, 1), "element_edge": ("element", 1, 1), "tie_edge": ("tie", 1, 1)},
)
