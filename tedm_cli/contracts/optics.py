"""optics.h5: the optical matrices and the read-out per kelvin."""

from __future__ import annotations

from tedm_cli.contracts.spec import AREAS, LAYOUT, Dataset, FileKind

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
