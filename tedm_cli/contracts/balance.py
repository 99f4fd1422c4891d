"""balance.h5: the blocks that balance the field at rest, and what each requirement costs."""

from __future__ import annotations

from tedm_cli.contracts.sensitivity import AT_REST
from tedm_cli.contracts.spec import BASIC, COUNT, FLAG, ID, NAMES, TM_FRAME, Dataset, FileKind, Values


class BalanceFile(FileKind):
    """Its datasets by name; `BALANCE` is the kind of file."""

    REQUIREMENT_NAME = Dataset(
        "/requirement/name", ("requirement",), "str", "1", "place, quantity, subsystem and requirement", values=NAMES
    )
    TEST_MASS = Dataset("/requirement/test_mass", ("requirement",), "str", "1", "test mass")
    MINUS = Dataset(
        "/requirement/minus",
        ("requirement",),
        "str",
        "1",
        "test mass whose value is subtracted, if a difference is judged; empty: test_mass by itself",
    )
    QUANTITY = Dataset(
        "/requirement/quantity", ("requirement",), "str", "1", "judged quantity at rest", values=Values(words=AT_REST)
    )
    SUBSYSTEM = Dataset(
        "/requirement/subsystem",
        ("requirement",),
        "str",
        "1",
        "whose field is judged: a subsystem, several joined by +, or all, which is everything in the model",
    )
    WHOLE = Dataset(
        "/requirement/whole", ("requirement",), "int", "1", "1 where that is everything in the model", values=FLAG
    )
    REQUIREMENT = Dataset(
        "/requirement/requirement", ("requirement",), "str", "1", "requirement that the range belongs to"
    )
    SOURCE = Dataset("/requirement/source", ("requirement",), "str", "1", "where the range is from")
    UNIT = Dataset(
        "/requirement/unit",
        ("requirement",),
        "str",
        "1",
        "unit of before, after, lower and upper",
        values=Values(words=("1/s^2", "m/s^2", "rad/s^2")),
    )
    LOWER = Dataset("/requirement/lower", ("requirement",), "float", None, "lower end of the range")
    UPPER = Dataset("/requirement/upper", ("requirement",), "float", None, "upper end of the range")
    BEFORE = Dataset(
        "/requirement/before",
        ("requirement",),
        "float",
        None,
        "value without the blocks; of a re-trim with the blocks that there were",
    )
    AFTER = Dataset("/requirement/after", ("requirement",), "float", None, "value with the blocks")
    OFF = Dataset(
        "/requirement/off",
        ("requirement",),
        "float",
        None,
        "how far the value may be off by all tolerances, which the blocks leave room for; 0 without tolerances",
    )
    CAP = Dataset(
        "/requirement/cap", ("requirement",), "float", "1", "largest ratio that the programme allowed, with the margin"
    )
    BLOCKING = Dataset(
        "/requirement/blocking",
        ("requirement",),
        "int",
        "1",
        "0: can be met; else the conflict that keeps it from being met, from 1, the worst first",
        values=COUNT,
    )
    REACHED = Dataset(
        "/requirement/reached", ("requirement",), "int", "1", "1 where a block changes the value at all", values=FLAG
    )
    PRICE = Dataset(
        "/requirement/price",
        ("requirement",),
        "float",
        "kg",
        "mass that a range wider by itself would save, by the relaxed programme: its dual value times the limit",
    )
    CONFLICT_RATIO = Dataset(
        "/conflict/ratio", ("conflict",), "float", "1", "least ratio that requirements which cannot all be met can have"
    )
    CONFLICT_WEIGHT = Dataset(
        "/conflict/weight",
        ("conflict", "requirement"),
        "float",
        "1",
        "weights, with the sum 1, of the requirements that keep each other from less",
    )
    CONFLICT_BESIDE = Dataset(
        "/conflict/beside",
        ("conflict", "requirement"),
        "float",
        "1",
        "by how much the ratio would fall by one unit of ratio more of requirements that could not be met before it",
    )
    CONFLICT_GAIN = Dataset(
        "/conflict/gain",
        ("conflict", "candidate"),
        "float",
        "1/kg",
        "by how much the ratio would fall by a kilogram more than the box holds",
    )
    CANDIDATE_NAME = Dataset(
        "/candidate/name", ("candidate",), "str", "1", "part of a box where mass may be", values=NAMES
    )
    CANDIDATE_BOX = Dataset("/candidate/box", ("candidate",), "str", "1", "box that it is of")
    CANDIDATE_IMAGES = Dataset(
        "/candidate/images", ("candidate",), "int", "1", "number of blocks of one mass", values=Values(least=1)
    )
    CANDIDATE_FULL = Dataset("/candidate/full", ("candidate",), "float", "kg", "largest mass, images included")
    CANDIDATE_RELAXED = Dataset(
        "/candidate/relaxed", ("candidate",), "float", "kg", "mass by the relaxed programme, images included"
    )
    CANDIDATE_MASS = Dataset("/candidate/mass", ("candidate",), "float", "kg", "mass, images included")
    CANDIDATE_SHIMS = Dataset(
        "/candidate/shims",
        ("candidate",),
        "int",
        "1",
        "whole shims or steps of each block; -1: its mass may be any",
        values=Values(least=-1),
    )
    MASS_BEFORE = Dataset(
        "/retrim/mass_before",
        ("candidate",),
        "float",
        "kg",
        "mass of each block as it was balanced, before its shims were changed",
        optional=True,
    )
    SHIMS_BEFORE = Dataset(
        "/retrim/shims_before",
        ("candidate",),
        "int",
        "1",
        "shims or steps that each block had; -1: its mass may be any",
        optional=True,
        values=Values(least=-1),
    )
    CANDIDATE_ROOM = Dataset(
        "/candidate/room",
        ("candidate",),
        "float",
        "kg/kg",
        "total mass that a kilogram more than the box holds would save, by the relaxed programme",
    )
    EFFECT = Dataset(
        "/candidate/effect",
        ("requirement", "candidate"),
        "float",
        None,
        "what a kilogram adds to each value, spread over the candidate and its images at their largest",
    )
    BLOCK_NAME = Dataset("/block/name", ("block",), "str", "1", "compensation mass", values=NAMES)
    BLOCK_CANDIDATE = Dataset(
        "/block/candidate",
        ("block",),
        "int",
        "1",
        "candidate that it is of",
        values=Values(rows_of="candidate"),
    )
    BLOCK_CENTRE = Dataset("/block/centre", ("block", "xyz"), "float", "m", "centre of the block", BASIC)
    BLOCK_SIZE = Dataset("/block/size", ("block", "xyz"), "float", "m", "edge lengths of the block")
    BLOCK_AXES = Dataset(
        "/block/axes", ("block", "xyz", "xyz_column"), "float", "1", "unit vectors of its edges (rows)", BASIC
    )
    BLOCK_MASS = Dataset("/block/mass", ("block",), "float", "kg", "mass of the block")
    BLOCK_GROUP = Dataset(
        "/block/group",
        ("block",),
        "str",
        "1",
        "group of thermal areas that it counts to; empty: the compensation masses",
    )
    BLOCK_TIE = Dataset("/block/tie", ("block",), "str", "1", "grids that it follows; empty: it does not move")
    COULD_BE_MET = Dataset(
        "/total/could_be_met",
        (),
        "int",
        "1",
        "limits that could be met together with the margin, of those that masses which are not whole reach",
        values=COUNT,
    )
    PRICE_ROW = Dataset("/thermal/row", ("row",), "str", "1", "output of each row", optional=True, values=NAMES)
    PRICE_UNIT = Dataset(
        "/thermal/unit",
        ("row",),
        "str",
        "1",
        "unit of each row by mean areas",
        optional=True,
        values=Values(words=("m/s^2/K", "rad/s^2/K")),
    )
    PRICE_AREA = Dataset(
        "/thermal/area", ("area",), "str", "1", "name of the thermal area", optional=True, values=NAMES
    )
    S_WITHOUT = Dataset(
        "/thermal/S_without",
        ("row", "area"),
        "float",
        None,
        "self-gravity sensitivity matrix [S_SG] of the model without the blocks, per unit of an area",
        TM_FRAME,
        optional=True,
    )
    S_ADDED = Dataset(
        "/thermal/S_added",
        ("row", "area"),
        "float",
        None,
        "what the blocks that are tied add to it",
        TM_FRAME,
        optional=True,
    )
    MARGIN = Dataset("/total/margin", (), "float", "1", "part of every limit that was to be left free")
    MASS = Dataset("/total/mass", (), "float", "kg", "mass of all blocks")
    RELAXED = Dataset("/total/relaxed", (), "float", "kg", "least mass where shims and steps need not be whole")
    BOUND = Dataset("/total/bound", (), "float", "kg", "mass that no whole shims and steps can be below")
    BEYOND = Dataset(
        "/total/beyond",
        (),
        "float",
        "1",
        "part of its cap that the worst ratio is above it, as shims and steps are whole",
    )
    TOLERANCE_NAME = Dataset(
        "/tolerance/name",
        ("tolerance",),
        "str",
        "1",
        "what may deviate: the mass of a block or part, or its place along an axis",
        optional=True,
        values=NAMES,
    )
    TOLERANCE_CHANGE = Dataset(
        "/tolerance/change",
        ("tolerance", "requirement"),
        "float",
        None,
        "change of each value by one standard deviation",
        optional=True,
    )
    TOLERANCE_SUM = Dataset(
        "/tolerance/sum",
        (),
        "str",
        "1",
        "how they add up",
        optional=True,
        values=Values(words=("worst case", "root sum of squares")),
    )
    TOLERANCE_SIGMAS = Dataset(
        "/tolerance/sigmas", (), "float", "1", "standard deviations that there is room for", optional=True
    )
    YIELD_DRAWS = Dataset(
        "/yield/draws", (), "int", "1", "builds drawn from their tolerances", optional=True, values=ID
    )
    YIELD_MET = Dataset(
        "/yield/met", (), "int", "1", "those of them that meet every requirement", optional=True, values=COUNT
    )
    YIELD_INTERVAL = Dataset(
        "/yield/interval",
        ("band_edge",),
        "float",
        "1",
        "95 % interval of the share that does (Clopper and Pearson)",
        optional=True,
    )
    YIELD_ERROR = Dataset(
        "/yield/error",
        (),
        "float",
        "1",
        "largest difference of values from those by the exact field of the blocks, of some builds, over their range",
        optional=True,
    )
    YIELD_EACH = Dataset(
        "/yield/each", ("requirement",), "float", "1", "share of the builds that meets each requirement", optional=True
    )
    YIELD_RATIO = Dataset(
        "/yield/ratio",
        ("quantile", "requirement"),
        "float",
        "1",
        "ratio that 5, 50 and 95 % of the builds stay below",
        optional=True,
    )


BALANCE = BalanceFile("balance", 1, "tedm balance")
