"""unit_loads.h5: displacements under the unit loads, with the model's geometry and mass."""

from __future__ import annotations

from tedm_cli.contracts.spec import AREAS, BASIC, COUNT, GRID, ID, Dataset, FileKind, Values

ELEMENTS = (
    *("CTETRA", "CPYRAM", "CPENTA", "CHEXA"),
    *("CTRIA3", "CTRIA6", "CTRIAR", "CQUAD4", "CQUAD8", "CQUADR", "CSHEAR"),
    *("CBAR", "CBEAM", "CROD", "CONROD", "CTUBE", "CBUSH"),
    *("CELAS1", "CELAS2", "CELAS3", "CELAS4", "CDAMP1", "CDAMP2", "CDAMP3", "CDAMP4", "CDAMP5", "CVISC", "CGAP"),
    *("CBUSH1D", "CBUSH2D", "CFAST", "CWELD", "CSEAM", "GENEL", "PLOTEL", "CHBDYG", "CHBDYE", "CHBDYP"),
)
"""Cards of elements that a file may hold: those with mass, and those that have none."""

UNIT_LOADS = FileKind(
    "unit_loads",
    4,
    "tedm ingest",
    {
        **GRID,
        **AREAS,
        "/area/load_K": Dataset(("area",), "float", "K", "temperature step applied to the area in its unit load"),
        "/area/mass": Dataset(("area",), "float", "kg", "lumped mass of the area's grids"),
        "/area/centroid": Dataset(("area", "xyz"), "float", "m", "mean position of the area's grids", BASIC),
        "/area/node_offset": Dataset(
            ("area_edge",),
            "int",
            "1",
            "start of each area in node_index, and its end",
            values=Values(starts_in="area_member"),
        ),
        "/area/node_index": Dataset(
            ("area_member",), "int", "1", "rows of /grid that belong to each area", values=Values(rows_of="node")
        ),
        "/translation": Dataset(("area", "node", "xyz"), "real", "m", "translation under each unit load", BASIC),
        "/rotation": Dataset(("area", "node", "xyz"), "real", "rad", "rotation under each unit load", BASIC),
        "/uniform/translation": Dataset(
            ("node", "xyz"), "real", "m", "translation when all areas are loaded together", BASIC, True
        ),
        "/uniform/rotation": Dataset(
            ("node", "xyz"), "real", "rad", "rotation when all areas are loaded together", BASIC, True
        ),
        "/uniform/load_K": Dataset((), "float", "K", "temperature step of the uniform load", optional=True),
        "/element/id": Dataset(("element",), "int", "1", "Nastran element id", values=ID),
        "/element/type": Dataset(("element",), "str", "1", "Nastran card name", values=Values(words=ELEMENTS)),
        "/element/property_id": Dataset(("element",), "int", "1", "Nastran property id, 0 for none", values=COUNT),
        "/element/node_offset": Dataset(
            ("element_edge",),
            "int",
            "1",
            "start of each element in node_index, and its end",
            values=Values(starts_in="element_member"),
        ),
        "/element/node_index": Dataset(
            ("element_member",),
            "int",
            "1",
            "rows of /grid, in Nastran's order; corners alone where a midside node lacks",
            values=Values(rows_of="node"),
        ),
        "/element/lever": Dataset(
            ("element_member", "xyz"), "float", "m", "offset of the element's mass from each of its nodes", BASIC
        ),
        "/element/weight": Dataset(
            ("element_member",), "float", "1", "density of the element's mass at each node over the mean of its nodes"
        ),
        "/element/mass": Dataset(("element",), "float", "kg", "element mass with its non-structural mass"),
        "/element/density": Dataset(("element",), "float", "kg/m^3", "material density"),
        "/element/expansion": Dataset(("element",), "float", "1/K", "coefficient of thermal expansion"),
        "/element/section": Dataset(
            ("element",), "float", "m or m^2", "thickness of plates, cross-section area of line elements, 0 for solids"
        ),
        "/mass/lumped": Dataset(
            ("node",), "float", "kg", "element mass shared equally to its nodes, plus concentrated masses"
        ),
        "/mass/concentrated": Dataset(("concentrated",), "float", "kg", "concentrated masses"),
        "/mass/concentrated_card": Dataset(
            ("concentrated",),
            "str",
            "1",
            "Nastran card; CMASS for three equal scalar masses",
            values=Values(words=("CONM1", "CONM2", "CMASS")),
        ),
        "/mass/concentrated_id": Dataset(
            ("concentrated",), "int", "1", "Nastran id of each concentrated mass", values=ID
        ),
        "/mass/concentrated_node": Dataset(
            ("concentrated",), "int", "1", "row of /grid of each concentrated mass", values=Values(rows_of="node")
        ),
        "/mass/concentrated_lever": Dataset(
            ("concentrated", "xyz"), "float", "m", "offset of each concentrated mass from its grid", BASIC
        ),
        "/mass/total": Dataset((), "float", "kg", "mass of the model"),
        "/mass/centre_of_gravity": Dataset(
            ("xyz",), "float", "m", "centre of gravity of the masses as they are spread over the elements", BASIC
        ),
        "/mass/inertia": Dataset(
            ("xyz", "xyz_column"), "float", "kg m^2", "inertia about the centre of gravity (plates as surfaces)", BASIC
        ),
    },
    derived_dims={"area_edge": ("area", 1, 1), "element_edge": ("element", 1, 1)},
)
