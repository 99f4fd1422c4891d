"""optics.h5: the optical matrices and the read-out per kelvin."""

from __future__ import annotations

from tedm_cli.contracts.spec import AREAS, COUNT, DOFS, LAYOUT, MOTIONS, NAMES, Dataset, FileKind, Values

_UNITS = Values(words=("m", "rad"))

OPTICS = FileKind(
    "optics",
    3,
    "tedm build-optics",
    {
        **AREAS,
        "/S_BW": Dataset(("ray_output", "element_dof"), "float", None, "optical sensitivity matrix", LAYOUT),
        "/P": Dataset(("laser_output", "ray_output"), "float", None, "optics law: photodiode outputs to read-out"),
        "/O_ideal": Dataset(("laser_output", "test_mass_dof"), "float", None, "test mass motion to laser read-out"),
        "/D": Dataset(("laser_output", "area"), "float", None, "laser read-out per kelvin of an area"),
        "/N/{set}": Dataset(("read_out", "area"), "float", None, "read-out noise per kelvin of an area"),
        "/N_rigid/{set}": Dataset(
            ("read_out", "area"), "float", None, "part of N: the bench moves as one against the test masses"
        ),
        "/N_distortion/{set}": Dataset(("read_out", "area"), "float", None, "part of N: the rest, the bench distorts"),
        "/motion": Dataset(
            ("element_dof", "area"),
            "float",
            None,
            "motion of the elements at their grids per kelvin of an area; of a test mass that of its expanding face",
            LAYOUT,
        ),
        "/rigid_motion": Dataset(
            ("element_dof", "area"), "float", None, "the part of it in which the bench moves as one", LAYOUT
        ),
        "/inverse/{set}": Dataset(
            ("read_out", "laser_output"), "float", None, "laser read-out to test mass motion: N = inverse D"
        ),
        "/gain/{set}": Dataset(
            ("read_out", "element_dof"), "float", None, "motion of an element at its grid to read-out: N = gain motion"
        ),
        "/common_mode/motion": Dataset(
            ("rigid_motion", "area"),
            "float",
            None,
            "rigid motion nearest to that of the bench: ux uy uz rx ry rz",
            LAYOUT,
        ),
        "/common_mode/about": Dataset(("xyz",), "float", "m", "point whose translation that is", LAYOUT),
        "/label/ray_output": Dataset(
            ("ray_output",), "str", "1", "rows of S_BW", values=Values(ends=("x", "y", "opl", "z1", "z2"), unique=True)
        ),
        "/label/ray_output_unit": Dataset(("ray_output",), "str", "1", "unit of the rows of S_BW", values=_UNITS),
        "/label/element_dof": Dataset(
            ("element_dof",),
            "str",
            "1",
            "columns of S_BW (m, rad)",
            values=Values(parts_of="/element/name", ends=MOTIONS, unique=True),
        ),
        "/label/laser_output": Dataset(
            ("laser_output",),
            "str",
            "1",
            "rows of P, O_ideal and D",
            values=Values(ends=("OPD", "WFT1", "WFT2"), unique=True),
        ),
        "/label/laser_output_unit": Dataset(
            ("laser_output",), "str", "1", "unit of the rows of P, O_ideal and D", values=_UNITS
        ),
        "/label/test_mass_dof": Dataset(
            ("test_mass_dof",),
            "str",
            "1",
            "columns of O_ideal (m, rad)",
            values=Values(of="/element/name", ends=MOTIONS, unique=True),
        ),
        "/label/read_out": Dataset(
            ("read_out",), "str", "1", "rows of N", values=Values(of="/element/name", ends=DOFS, unique=True)
        ),
        "/label/read_out_unit": Dataset(("read_out",), "str", "1", "unit of the read-out", values=_UNITS),
        "/set/name": Dataset(("set",), "str", "1", "redundant sets of photodiodes", values=NAMES),
        "/set/condition": Dataset(("set",), "float", "1", "condition number of O of the set (m, rad)"),
        "/rank": Dataset((), "int", "1", "rank of O_ideal", values=COUNT),
        "/singular_values": Dataset(("test_mass_dof_singular",), "float", "1", "singular values of O_ideal"),
        "/residual/name": Dataset(("residual",), "str", "1", "invariance that the matrices must keep", values=NAMES),
        "/residual/value": Dataset(("residual",), "float", "1", "dimensionless residual of the invariance"),
        "/residual/limit": Dataset(
            ("residual",), "float", "1", "largest residual allowed; infinite: not judged", open_ended=True
        ),
        "/origin/S_BW": Dataset((), "str", "1", "where S_BW comes from: ray trace, or the name of an imported file"),
        "/origin/P": Dataset((), "str", "1", "where P comes from: layout, or the name of an imported file"),
        "/element/name": Dataset(
            ("element",), "str", "1", "optical elements and test masses, six columns of S_BW each", values=NAMES
        ),
        "/element/pivot": Dataset(
            ("element", "xyz"), "float", "m", "point that the rotations of each element are about", LAYOUT
        ),
        "/reference_point_offset": Dataset(
            ("optical", "xyz"), "float", "m", "layout reference point minus finite-element grid", LAYOUT
        ),
        "/optical/name": Dataset(("optical",), "str", "1", "optical element", values=NAMES),
    },
    fixed_dims={"xyz": 3, "rigid_motion": 6},
    derived_dims={"element_dof": ("element", 6, 0)},
    families={"set": "/set/name"},
)
