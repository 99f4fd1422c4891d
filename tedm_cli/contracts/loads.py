"""loads.h5: what loads other than temperature do to the structure, to the test masses and to the read-outs; modes."""

from __future__ import annotations

from tedm_cli.contracts.spec import (
    ACCELERATIONS,
    BASIC,
    DOFS,
    LAYOUT,
    NAMES,
    Dataset,
    FileKind,
    GridIds,
    Values,
)

KINDS_OF_LOAD = ("motion", "gravity_release", "moisture_release")
UNITS_OF_LOAD = ("m", "rad", "1")
_PER_LOAD = "per /load/unit"
_READ_OUT, _MODES = "read_out", "mode"


def _read_out(path: str, dims: tuple[str, ...], dtype: str, units: str | None, long_name: str) -> Dataset:
    """Of projects with optics."""
    return Dataset(path, dims, dtype, units, long_name, optional=True, group=_READ_OUT)


def _judged(path: str, dims: tuple[str, ...], dtype: str, units: str | None, long_name: str) -> Dataset:
    """Of layouts whose beams can be traced."""
    return Dataset(path, dims, dtype, units, long_name, optional=True, group="layout", open_ended="load" in dims)


class LoadsFile(GridIds, FileKind):
    """Its datasets by name; `LOADS` is the kind of file."""

    LOAD_NAME = Dataset("/load/name", ("load",), "str", "1", "loads, columns of all that follows", values=NAMES)
    LOAD_KIND = Dataset(
        "/load/kind",
        ("load",),
        "str",
        "1",
        "enforced motion of supports; gravity or moisture that is gone in flight",
        values=Values(words=KINDS_OF_LOAD),
    )
    LOAD_UNIT = Dataset(
        "/load/unit",
        ("load",),
        "str",
        "1",
        "unit of each load: m or rad of a motion, 1 of a whole release",
        values=Values(words=UNITS_OF_LOAD),
    )
    LOAD_FOOT = Dataset(
        "/load/foot", ("load",), "str", "1", "the foot that moves, or INTERFACE, all supports as one; else empty"
    )
    TRANSLATION = Dataset(
        "/D/translation",
        ("load", "node", "xyz"),
        "real",
        None,
        "displacement of every grid by each load",
        BASIC,
    )
    RIGID_TRANSLATION = Dataset(
        "/rigid/translation",
        ("load", "xyz"),
        "float",
        None,
        "of it, motion of the whole structure as one (best fit weighted by mass): of its centre of gravity",
        BASIC,
    )
    RIGID_ROTATION = Dataset(
        "/rigid/rotation", ("load", "xyz"), "float", None, "the same, rotation of the structure as one", BASIC
    )
    LARGEST = Dataset("/largest/translation", ("load",), "float", None, "largest displacement of any grid")
    LARGEST_DISTORTION = Dataset(
        "/largest/distortion",
        ("load",),
        "float",
        None,
        "the same, without the motion of the structure as one",
    )
    ROW_LABEL = Dataset(
        "/row/label",
        ("row",),
        "str",
        "1",
        "outputs: accelerations of the test masses, then the read-outs of every set",
        values=Values(ends=(*ACCELERATIONS, *DOFS), unique=True),
    )
    ROW_UNIT = Dataset(
        "/row/unit",
        ("row",),
        "str",
        "1",
        "unit of each output",
        values=Values(words=("m/s^2", "rad/s^2", "m", "rad")),
    )
    OUTPUT = Dataset("/output/whole", ("row", "load"), "float", None, "what each load does to each output")
    OUTPUT_DISTORTION = Dataset(
        "/output/distortion",
        ("row", "load"),
        "float",
        None,
        "of it, by distortion: without the motion of the structure as one (accelerations), or of each bench as one"
        " (read-outs)",
    )
    LABEL_ELEMENT_DOF = _read_out("/label/element_dof", ("element_dof",), "str", "1", "motions of optical elements")
    MOTION = Dataset(
        "/optics/motion",
        ("element_dof", "load"),
        "float",
        None,
        "motion of the optical elements at their grids",
        LAYOUT,
        True,
        group=_READ_OUT,
    )
    BENCH_DISTORTION = _read_out(
        "/largest/bench_distortion",
        ("load",),
        "float",
        None,
        "largest displacement of any optical element, without the motion of its bench as one",
    )
    LABEL_RAY_OUTPUT = _read_out(
        "/label/ray_output", ("ray_output",), "str", "1", "x, y, optical path and slopes of each beam on its photodiode"
    )
    LABEL_RAY_OUTPUT_UNIT = _read_out("/label/ray_output_unit", ("ray_output",), "str", "1", "unit of each")
    BEAM_SHIFT = _read_out(
        "/optics/beam_shift", ("ray_output", "load"), "float", None, "what each load does to the beams: S_BW motion"
    )
    MARGIN_CHECK = _judged("/margin/check", ("margin",), "str", "1", "check of the layout, as `check-layout` has it")
    MARGIN_WHERE = _judged("/margin/where", ("margin",), "str", "1", "step of a path, or photodiode")
    MARGIN_ELEMENT = _judged("/margin/element", ("margin",), "str", "1", "element that is judged")
    MARGIN_UNIT = _judged("/margin/unit", ("margin",), "str", "1", "unit of value and limit")
    MARGIN_LIMIT = _judged("/margin/limit", ("margin",), "float", "see /margin/unit", "what is allowed")
    MARGIN_BEFORE = _judged("/margin/before", ("margin",), "float", "see /margin/unit", "value in the layout as it is")
    MARGIN_AFTER = _judged(
        "/margin/after",
        ("margin", "load"),
        "float",
        "see /margin/unit",
        "value after each release; NaN of motions, and where the beam no longer comes",
    )
    MODE_FREQUENCY = Dataset(
        "/mode/frequency",
        ("mode",),
        "float",
        "Hz",
        "lowest natural frequencies, ascending; rigid motions are left out",
        optional=True,
        group=_MODES,
    )
    MODE_EFFECTIVE_MASS = Dataset(
        "/mode/effective_mass",
        ("mode", "motion"),
        "float",
        "kg (three), kg m^2 (three)",
        "effective mass along and about the axes through the centre of gravity",
        BASIC,
        True,
        group=_MODES,
    )
    MODE_MASS = Dataset(
        "/mode/mass",
        ("motion",),
        "float",
        "kg (three), kg m^2 (three)",
        "mass and inertia of the structure as one, which the effective masses of all modes sum to, less the supports'",
        BASIC,
        True,
        group=_MODES,
    )
    MODE_RIGID = Dataset(
        "/mode/rigid",
        ("rigid",),
        "str",
        "1",
        "rigid motions that nothing holds, which are not among the modes",
        optional=True,
        group=_MODES,
    )
    CHECK_INTERFACE = Dataset(
        "/check/interface",
        (),
        "float",
        "1",
        "largest distortion by motions of all supports as one, over the displacement; rounding, unless something else"
        " holds the structure; 0 without feet",
    )
    CHECK_RESIDUAL = Dataset(
        "/check/residual",
        (),
        "float",
        "1",
        "largest relative residual |K u - f| / |f|; NaN of another solver's results",
        open_ended=True,
    )


LOADS = LoadsFile("loads", 1, "tedm build-loads", fixed_dims={"xyz": 3, "motion": 6})
