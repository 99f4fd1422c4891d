"""figure_6_2.h5: acceleration noise of test masses whose positions are imposed."""

from __future__ import annotations

from tedm_cli.contracts.spec import NAMES, Dataset, FileKind, Values


class ImposedFile(FileKind):
    """Its datasets by name; `IMPOSED` is the kind of file."""

    FREQUENCY = Dataset("/frequency", ("frequency",), "float", "Hz", "frequency")
    MOTION_SOURCE = Dataset("/motion/source", (), "str", "1", "requirement whose amplitude the positions have")
    MOTION_AMPLITUDE = Dataset(
        "/motion/amplitude", ("frequency",), "float", "m/sqrt(Hz)", "ASD of the position of each test mass along its x"
    )
    REQUIREMENT_NAME = Dataset("/requirement/name", (), "str", "1", "requirement that the noise is compared with")
    REQUIREMENT_SOURCE = Dataset("/requirement/source", (), "str", "1", "document it is from")
    REQUIREMENT_LEVEL = Dataset(
        "/requirement/level", (), "float", "m s^-2/sqrt(Hz)", "limit far below the frequencies at which it rises"
    )
    REQUIREMENT_AMPLITUDE = Dataset(
        "/requirement/amplitude", ("frequency",), "float", "m s^-2/sqrt(Hz)", "limit on the ASD"
    )
    ROW_MODEL = Dataset("/row/model", ("row",), "str", "1", "whose stiffness: the published tables, or this model")
    ROW_TEST_MASS = Dataset("/row/test_mass", ("row",), "str", "1", "test mass that is accelerated")
    SOURCE_NAME = Dataset(
        "/source/name",
        ("source",),
        "str",
        "1",
        "sources of stiffness",
        values=Values(unique=True, words=("structure", "other test mass", "compensation masses")),
    )
    MOTION_NAME = Dataset(
        "/motion/name", ("motion",), "str", "1", "of the test mass itself, and of the other one", values=NAMES
    )
    STIFFNESS = Dataset(
        "/stiffness",
        ("row", "source", "motion"),
        "float",
        "1/s^2",
        "acceleration along x per motion along x; of the own motion positive means destabilising",
    )
    ASD = Dataset("/asd", ("row", "frequency"), "float", "m s^-2/sqrt(Hz)", "acceleration noise by all sources")
    ASD_ALONE = Dataset(
        "/asd_alone", ("row", "source", "frequency"), "float", "m s^-2/sqrt(Hz)", "the same by each source alone"
    )
    SHARE = Dataset(
        "/share", ("row", "source"), "float", "1", "signed part of the source in the power; all sum to 1 (0: no noise)"
    )
    RATIO = Dataset("/ratio", ("row",), "float", "1", "largest ratio of noise to requirement, without a safety factor")
    BINDING_FREQUENCY = Dataset("/binding_frequency", ("row",), "float", "Hz", "frequency of the largest ratio")


IMPOSED = ImposedFile("figure_6_2", 1, "tedm simulate --figure-6.2", fixed_dims={"motion": 2})
