"""One table per kind of HDF5 file: its datasets, their dimensions, type, unit, frame and meaning.

The reader and the writer in `tedm_cli.store` both check against these tables; `docs/files.md` is printed from them.
A path with a name in braces (`/psd/{output}`) stands for one dataset per name. A unit of `None` is given by the writer.
Changing a table in a way that older files do not fit raises the kind's `version`.
"""

from __future__ import annotations

from dataclasses import dataclass, field

BASIC = "Nastran basic frame"
TM_FRAME = "nominal frame of the test mass (origin at its centre, axes along its edges)"
LAYOUT = "layout frame"


@dataclass(frozen=True)
class Dataset:
    """What one dataset must be: symbolic dimensions, type, unit, meaning, frame.

    Types are `float` (64 bit), `real` (64 bit, or 32 where that changes no number), `int` (64 bit), `str`.
    """

    dims: tuple[str, ...]
    dtype: str
    units: str | None
    long_name: str
    frame: str = ""
    optional: bool = False


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

UNIT_LOADS = FileKind(
    "unit_loads",
    3,
    "tedm ingest",
    {
        **GRID,
        **AREAS,
        "/area/load_K": Dataset(("area",), "float", "K", "temperature step applied to the area in its unit load"),
        "/area/mass": Dataset(("area",), "float", "kg", "lumped mass of the area's grids"),
        "/area/centroid": Dataset(("area", "xyz"), "float", "m", "mean position of the area's grids", BASIC),
        "/area/node_offset": Dataset(("area_edge",), "int", "1", "start of each area in node_index, and its end"),
        "/area/node_index": Dataset(("area_member",), "int", "1", "rows of /grid that belong to each area"),
        "/translation": Dataset(("area", "node", "xyz"), "real", "m", "translation under each unit load", BASIC),
        "/rotation": Dataset(("area", "node", "xyz"), "real", "rad", "rotation under each unit load", BASIC),
        "/uniform/translation": Dataset(
            ("node", "xyz"), "real", "m", "translation when all areas are loaded together", BASIC, True
        ),
        "/uniform/rotation": Dataset(
            ("node", "xyz"), "real", "rad", "rotation when all areas are loaded together", BASIC, True
        ),
        "/uniform/load_K": Dataset((), "float", "K", "temperature step of the uniform load", optional=True),
        "/element/id": Dataset(("element",), "int", "1", "Nastran element id"),
        "/element/type": Dataset(("element",), "str", "1", "Nastran card name"),
        "/element/property_id": Dataset(("element",), "int", "1", "Nastran property id"),
        "/element/node_offset": Dataset(("element_edge",), "int", "1", "start of each element in node_index"),
        "/element/node_index": Dataset(
            ("element_member",),
            "int",
            "1",
            "rows of /grid, in Nastran's order; corners alone where a midside node lacks",
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
            ("concentrated",), "str", "1", "CONM1, CONM2, or CMASS for three equal scalar masses"
        ),
        "/mass/concentrated_id": Dataset(("concentrated",), "int", "1", "Nastran id of each concentrated mass"),
        "/mass/concentrated_node": Dataset(("concentrated",), "int", "1", "row of /grid of each concentrated mass"),
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
)

DISTORTION = FileKind(
    "distortion",
    2,
    "tedm build-distortion",
    {
        "/grid/id": GRID["/grid/id"],
        **AREAS,
        "/D/translation": Dataset(
            ("area", "node", "xyz"), "real", "m/K", "distortion matrix [D]: translation per kelvin of an area", BASIC
        ),
        "/D/offset_node": Dataset(
            ("offset_node",), "int", "1", "rows of /grid from which something with mass is offset, ascending"
        ),
        "/D/rotation": Dataset(
            ("area", "offset_node", "xyz"), "float", "rad/K", "rotation of these grids per kelvin of an area", BASIC
        ),
        "/optical/name": Dataset(("optical",), "str", "1", "optical element"),
        "/optical/grid": Dataset(("optical",), "int", "1", "Nastran grid that carries the element's motion"),
        "/optical/position": Dataset(("optical", "xyz"), "float", "m", "position of that grid", BASIC),
        "/D_opt/translation": Dataset(
            ("area", "optical", "xyz"), "float", "m/K", "translation of the optical elements per kelvin", BASIC
        ),
        "/D_opt/rotation": Dataset(
            ("area", "optical", "xyz"), "float", "rad/K", "rotation of the optical elements per kelvin", BASIC
        ),
        "/check/superposition_translation": Dataset(
            (),
            "float",
            "1",
            "largest |sum over areas - uniform| over the largest |uniform|, translations",
            optional=True,
        ),
        "/check/superposition_optics": Dataset(
            (), "float", "1", "the same for the rotations of the optical elements", optional=True
        ),
        "/check/max_translation": Dataset(("area",), "float", "m/K", "largest translation of any grid"),
        "/check/rigid_translation": Dataset(
            ("area", "xyz"), "float", "m/K", "translation of the best-fit rigid motion at the centre of gravity", BASIC
        ),
        "/check/rigid_rotation": Dataset(
            ("area", "xyz"), "float", "rad/K", "rotation of the best-fit rigid motion", BASIC
        ),
    },
)

SENSITIVITY = FileKind(
    "sensitivity",
    2,
    "tedm build-sensitivity",
    {
        "/grid/id": GRID["/grid/id"],
        **AREAS,
        "/S": Dataset(("row", "area"), "float", None, "self-gravity sensitivity matrix [S_SG]", TM_FRAME),
        "/row/label": Dataset(("row",), "str", "1", "output of each row of S and of the operator"),
        "/row/unit": Dataset(("row",), "str", "1", "unit of each row of S"),
        "/test_mass/name": Dataset(("test_mass",), "str", "1", "name of the test mass"),
        "/test_mass/position": Dataset(("test_mass", "xyz"), "float", "m", "centre of the test mass", BASIC),
        "/test_mass/side": Dataset(("test_mass", "xyz"), "float", "m", "edge lengths"),
        "/test_mass/mass": Dataset(("test_mass",), "float", "kg", "mass"),
        "/test_mass/axes": Dataset(
            ("test_mass", "xyz", "xyz_column"), "float", "1", "unit vectors of the test mass frame (rows)", BASIC
        ),
        "/source/name": Dataset(("source",), "str", "1", "what pulls: structure, other test mass, compensation masses"),
        "/source/quadrature_error": Dataset(
            ("test_mass", "source"),
            "float",
            "1",
            "quadrature error: tolerance per element for the structure (nan: lumped), estimate for the others",
        ),
        "/source/points": Dataset(("test_mass", "source"), "int", "1", "points the source is made of"),
        "/source/mass_model": Dataset((), "str", "1", "how the structure's mass is represented: quadrature or lumped"),
        "/dc/acceleration": Dataset(
            ("test_mass", "source", "xyz"), "float", "m/s^2", "acceleration of the test mass at rest", TM_FRAME
        ),
        "/dc/angular_acceleration": Dataset(
            ("test_mass", "source", "xyz"),
            "float",
            "rad/s^2",
            "angular acceleration of the test mass at rest",
            TM_FRAME,
        ),
        "/stiffness/gamma_lin": Dataset(
            ("test_mass", "source", "xyz", "xyz_column"), "float", "1/s^2", "force by test mass translation", TM_FRAME
        ),
        "/stiffness/omega_lin": Dataset(
            ("test_mass", "source", "xyz", "xyz_column"),
            "float",
            "1/(m s^2)",
            "torque by test mass translation",
            TM_FRAME,
        ),
        "/stiffness/gamma_ang": Dataset(
            ("test_mass", "source", "xyz", "xyz_column"),
            "float",
            "m/(s^2 rad)",
            "force by test mass rotation",
            TM_FRAME,
        ),
        "/stiffness/omega_ang": Dataset(
            ("test_mass", "source", "xyz", "xyz_column"),
            "float",
            "1/(s^2 rad)",
            "torque by test mass rotation",
            TM_FRAME,
        ),
        "/stiffness/linearised": Dataset(
            ("tm_output", "tm_motion"),
            "float",
            None,
            "linearised equations of motion of all test masses: (F/M, T/I) by small translations and rotations",
            TM_FRAME,
        ),
        "/label/tm_output": Dataset(("tm_output",), "str", "1", "rows of /stiffness/linearised"),
        "/label/tm_output_unit": Dataset(("tm_output",), "str", "1", "unit of the rows"),
        "/label/tm_motion": Dataset(("tm_motion",), "str", "1", "columns of /stiffness/linearised"),
        "/label/tm_motion_unit": Dataset(("tm_motion",), "str", "1", "unit of the columns"),
        "/operator/G": Dataset(
            ("row", "node", "xyz"),
            "float",
            None,
            "operator of S = -G D: rows in /row, displacement in basic frame",
            BASIC,
        ),
        "/operator/offset_node": Dataset(("offset_node",), "int", "1", "rows of /grid that G_rotation is about"),
        "/operator/G_rotation": Dataset(
            ("row", "offset_node", "xyz"),
            "float",
            None,
            "part of the operator that the rotations of these grids contribute",
            BASIC,
        ),
        "/area_contribution/acceleration": Dataset(
            ("test_mass", "area", "xyz"),
            "float",
            "m/s^2",
            "part of the DC acceleration made by the mass that its grids carry",
            TM_FRAME,
        ),
        "/area_contribution/angular_acceleration": Dataset(
            ("test_mass", "area", "xyz"),
            "float",
            "rad/s^2",
            "part of the DC angular acceleration that an area's mass makes",
            TM_FRAME,
        ),
        "/area_contribution/gamma_lin": Dataset(
            ("test_mass", "area", "xyz", "xyz_column"),
            "float",
            "1/s^2",
            "part of the force by test mass translation that an area's mass makes",
            TM_FRAME,
        ),
        "/dc_verdict/test_mass": Dataset(("dc_verdict",), "str", "1", "test mass"),
        "/dc_verdict/quantity": Dataset(("dc_verdict",), "str", "1", "judged quantity at rest"),
        "/dc_verdict/subsystem": Dataset(
            ("dc_verdict",), "str", "1", "inertial sensor of the test mass (IS), rest of the model (LTP), or both"
        ),
        "/dc_verdict/unit": Dataset(("dc_verdict",), "str", "1", "unit of value, lower and upper"),
        "/dc_verdict/value": Dataset(("dc_verdict",), "float", None, "value of the quantity", TM_FRAME),
        "/dc_verdict/lower": Dataset(("dc_verdict",), "float", None, "lower end of the allocated range"),
        "/dc_verdict/upper": Dataset(("dc_verdict",), "float", None, "upper end of the allocated range"),
        "/dc_verdict/ratio": Dataset(("dc_verdict",), "float", "1", "value over the end of the range on its side"),
        "/dc_verdict/passed": Dataset(("dc_verdict",), "int", "1", "1 where the value is within the range"),
    },
)

OPTICS = FileKind(
    "optics",
    1,
    "tedm build-optics",
    {
        **AREAS,
        "/S_BW": Dataset(("ray_output", "element_dof"), "float", None, "optical sensitivity matrix", LAYOUT),
        "/P": Dataset(("laser_output", "ray_output"), "float", None, "optics law: photodiode outputs to read-out"),
        "/O_ideal": Dataset(("laser_output", "test_mass_dof"), "float", None, "test mass motion to laser read-out"),
        "/D": Dataset(("laser_output", "area"), "float", None, "laser read-out per kelvin of an area"),
        "/N/{set}": Dataset(("read_out", "area"), "float", None, "read-out noise per kelvin of an area"),
        "/label/ray_output": Dataset(("ray_output",), "str", "1", "rows of S_BW"),
        "/label/ray_output_unit": Dataset(("ray_output",), "str", "1", "unit of the rows of S_BW"),
        "/label/element_dof": Dataset(("element_dof",), "str", "1", "columns of S_BW (m, rad)"),
        "/label/laser_output": Dataset(("laser_output",), "str", "1", "rows of P, O_ideal and D"),
        "/label/laser_output_unit": Dataset(("laser_output",), "str", "1", "unit of the rows of P, O_ideal and D"),
        "/label/test_mass_dof": Dataset(("test_mass_dof",), "str", "1", "columns of O_ideal (m, rad)"),
        "/label/read_out": Dataset(("read_out",), "str", "1", "rows of N"),
        "/label/read_out_unit": Dataset(("read_out",), "str", "1", "unit of the read-out"),
        "/set/name": Dataset(("set",), "str", "1", "redundant sets of photodiodes"),
        "/set/condition": Dataset(("set",), "float", "1", "condition number of O of the set (m, rad)"),
        "/rank": Dataset((), "int", "1", "rank of O_ideal"),
        "/singular_values": Dataset(("test_mass_dof_singular",), "float", "1", "singular values of O_ideal"),
        "/residual/name": Dataset(("residual",), "str", "1", "invariance that the matrices must keep"),
        "/residual/value": Dataset(("residual",), "float", "1", "dimensionless residual of the invariance"),
        "/reference_point_offset": Dataset(
            ("optical", "xyz"), "float", "m", "finite-element grid minus layout reference point", LAYOUT
        ),
        "/optical/name": Dataset(("optical",), "str", "1", "optical element"),
    },
)

CASE = FileKind(
    "case",
    1,
    "tedm run-case",
    {
        **AREAS,
        "/case/id": Dataset((), "str", "1", "case number"),
        "/case/title": Dataset((), "str", "1", "which temperatures move together"),
        "/case/safety_factor": Dataset((), "float", "1", "factor on amplitudes when judged (not applied to /psd)"),
        "/case/block": Dataset(("area",), "int", "1", "correlated block of each area; -1: silent"),
        "/frequency": Dataset(("frequency",), "float", "Hz", "frequency"),
        "/temperature/spectrum": Dataset(("area",), "int", "1", "row of /temperature/asd that each area has"),
        "/temperature/asd": Dataset(
            ("spectrum", "frequency"), "float", "K/sqrt(Hz)", "one-sided amplitude spectral densities of the areas"
        ),
        "/temperature/model": Dataset((), "str", "1", "temperature model and its parameters"),
        "/output/label": Dataset(("output",), "str", "1", "outputs"),
        "/output/unit": Dataset(("output",), "str", "1", "unit of the output"),
        "/output/kind": Dataset(("output",), "str", "1", "quantity of the output"),
        "/psd/{output}": Dataset(("frequency",), "float", None, "one-sided power spectral density of the output"),
        "/bounds/maximum/{output}": Dataset(
            ("frequency",), "float", None, "largest PSD over all correlations of the active areas"
        ),
        "/bounds/maximum_non_negative/{output}": Dataset(
            ("frequency",), "float", None, "largest PSD over all correlations without a negative entry"
        ),
        "/bounds/known_blocks/{output}": Dataset(
            ("frequency",), "float", None, "largest PSD when only the correlation between the blocks is unknown"
        ),
        "/bounds/minimum/{output}": Dataset(("frequency",), "float", None, "smallest PSD over all correlations"),
        "/contribution/frequency": Dataset(("output",), "float", "Hz", "frequency the contributions are given at"),
        "/contribution/amplitude/{output}": Dataset(
            ("area",), "float", None, "signed contribution: sensitivity times amplitude spectral density"
        ),
        "/contribution/share": Dataset(
            ("output", "area"), "float", "1", "share of the PSD; the shares of a row sum to 1"
        ),
        "/contribution/band": Dataset(("output", "band_edge"), "float", "Hz", "band of band_share"),
        "/contribution/band_share": Dataset(("output", "area"), "float", "1", "share of the power in the band"),
        "/verdict/requirement": Dataset(("verdict",), "str", "1", "requirement"),
        "/verdict/output": Dataset(("verdict",), "str", "1", "output that is judged"),
        "/verdict/ratio": Dataset(
            ("verdict",), "float", "1", "largest ratio of safety factor x ASD to the requirement"
        ),
        "/verdict/binding_frequency": Dataset(("verdict",), "float", "Hz", "frequency of the largest ratio"),
        "/verdict/passed": Dataset(("verdict",), "int", "1", "1 where the ratio is at most 1"),
        "/filter_sensitivity/order": Dataset(("order",), "float", "1", "order of the low-pass filter", optional=True),
        "/filter_sensitivity/corner": Dataset(
            ("corner",), "float", "Hz", "corner of the low-pass filter", optional=True
        ),
        "/filter_sensitivity/ratio": Dataset(
            ("verdict", "order", "corner"), "float", "1", "ratio of each verdict with that filter", optional=True
        ),
        "/requirement/name": Dataset(("requirement",), "str", "1", "requirement"),
        "/requirement/source": Dataset(("requirement",), "str", "1", "where the requirement comes from"),
        "/requirement/unit": Dataset(("requirement",), "str", "1", "unit of the amplitude"),
        "/requirement/band": Dataset(("requirement", "band_edge"), "float", "Hz", "band of the requirement"),
        "/requirement/amplitude": Dataset(
            ("requirement", "frequency"), "float", None, "amplitude spectral density; NaN outside the band"
        ),
        "/realisation/frequency": Dataset(
            ("bin",), "float", "Hz", "frequency of the estimate from a realisation", optional=True
        ),
        "/realisation/psd": Dataset(
            ("output", "bin"),
            "float",
            None,
            "Welch's estimate of the one-sided PSD (Kaiser's window, beta = 22)",
            optional=True,
        ),
        "/realisation/exact": Dataset(
            ("output", "bin"), "float", None, "exact one-sided PSD at these frequencies", optional=True
        ),
        "/realisation/degrees_of_freedom": Dataset(
            ("bin",), "float", "1", "equivalent degrees of freedom of the estimate (chi-square)", optional=True
        ),
        "/realisation/rate": Dataset((), "float", "Hz", "samples per second of the realisation", optional=True),
        "/realisation/samples": Dataset((), "int", "1", "samples of the realisation", optional=True),
        "/realisation/seed": Dataset((), "int", "1", "seed of the random numbers", optional=True),
    },
    fixed_dims={"band_edge": 2},
)

SERIES = FileKind(
    "series",
    1,
    "tedm run-series",
    {
        **AREAS,
        "/temperature/column": Dataset(
            ("area",), "str", "1", "column of the temperature series that the area follows; empty: constant"
        ),
        "/temperature/source": Dataset((), "str", "1", "name of the temperature series and of its file"),
        "/temperature/treatment": Dataset((), "str", "1", "what was removed and how the series was resampled"),
        "/time": Dataset(("sample",), "float", "s", "time of the samples"),
        "/output/label": Dataset(("output",), "str", "1", "outputs"),
        "/output/unit": Dataset(("output",), "str", "1", "unit of the output"),
        "/output/kind": Dataset(("output",), "str", "1", "quantity of the output"),
        "/output/rms": Dataset(("output",), "float", None, "root mean square of the series"),
        "/output/peak": Dataset(("output",), "float", None, "largest absolute value of the series"),
        "/series/{output}": Dataset(("sample",), "float", None, "time series of the output"),
        "/frequency": Dataset(("frequency",), "float", "Hz", "frequency of the estimates"),
        "/psd/{output}": Dataset(("frequency",), "float", None, "estimated one-sided power spectral density"),
        "/degrees_of_freedom": Dataset(
            ("frequency",), "float", "1", "equivalent degrees of freedom of the estimate (chi-square)"
        ),
        "/verdict/safety_factor": Dataset((), "float", "1", "factor on amplitudes when judged, not applied elsewhere"),
        "/verdict/requirement": Dataset(("verdict",), "str", "1", "requirement"),
        "/verdict/output": Dataset(("verdict",), "str", "1", "output that is judged"),
        "/verdict/ratio": Dataset(
            ("verdict",), "float", "1", "largest ratio of safety factor x estimated ASD to the requirement"
        ),
        "/verdict/binding_frequency": Dataset(("verdict",), "float", "Hz", "frequency of the largest ratio"),
        "/verdict/passed": Dataset(("verdict",), "int", "1", "1 where the ratio is at most 1"),
        "/verdict/band_rms": Dataset(("verdict",), "float", None, "rms of the output in the band"),
        "/verdict/band_limit": Dataset(("verdict",), "float", None, "rms of noise at the requirement in the band"),
    },
)

KINDS = {kind.name: kind for kind in (UNIT_LOADS, DISTORTION, SENSITIVITY, OPTICS, CASE, SERIES)}


_PREFACE = """\
# Files between the stages

Printed from `tedm_cli/contracts.py` by `python -m tedm_cli.contracts > docs/files.md`.

All files are HDF5 with netCDF-4 dimension scales: they open in h5py, MATLAB (`h5read`) and, group by group, in
`xarray.open_dataset(file, group="/dc", engine="h5netcdf")`. Every dataset MUST have the attributes `units` and
`long_name`; vectors MUST name their `frame`. Arrays over grids are chunked along the grids.

`float` and `int` are of 64 bits. `real` is float32 where every number is exact in it (an OP2 in single precision, grids
in the basic frame, loads of 1 K) and float64 otherwise: turn it into double precision before you compute with it.

Root attributes: `schema` (`tedm.<kind>`), `schema_version`, `tedm_version`, `command_line`, versions of Python and of
the libraries. `/provenance` holds the configurations verbatim and the SHA-256 of every input; paths are relative to the
file. There is no time stamp: the same inputs MUST give the same bytes. A reader MUST refuse a file of another kind or
version, and writers replace the old file only when the new one is complete.

Accelerations are force over mass and torque over moment of inertia, component by component; stiffnesses are their
derivatives by motion of the test mass, normalised the same way. Signs are in [method.md](method.md).
"""


def markdown() -> str:
    """The tables as the text of docs/files.md."""
    lines = _PREFACE.splitlines()
    for kind in KINDS.values():
        lines += ["", f"## {kind.name}", "", f"Version {kind.version}, made by `{kind.made_by}`.", ""]
        lines += ["| dataset | dimensions | type | unit | meaning |", "|---|---|---|---|---|"]
        for path, d in kind.datasets.items():
            dims = ", ".join(f"{n}={kind.fixed_dims[n]}" if n in kind.fixed_dims else n for n in d.dims) or "scalar"
            unit = "varies" if d.units is None else d.units
            meaning = d.long_name + (f"; {d.frame}" if d.frame else "") + (" (optional)" if d.optional else "")
            lines.append(f"| `{path}` | {dims} | {d.dtype} | {unit} | {meaning} |")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    print(markdown(), end="")
