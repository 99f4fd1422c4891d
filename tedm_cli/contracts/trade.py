"""trade.h5: variants of a design by several criteria."""

from __future__ import annotations

from tedm_cli.contracts.spec import COUNT, FLAG, NAMES, Dataset, FileKind, Values

GOALS = ("min", "max")
JUDGED, NOT_JUDGED = ("passed", "violated"), ""


def _of_variant(
    name: str, dtype: str, long_name: str, values: Values = Values(), *, open_ended: bool = False
) -> Dataset:
    return Dataset(f"/variant/{name}", ("variant",), dtype, "1", long_name, values=values, open_ended=open_ended)


def _of_criterion(
    name: str, dtype: str, long_name: str, values: Values = Values(), *, units: str = "1", open_ended: bool = False
) -> Dataset:
    path = f"/criterion/{name}"
    return Dataset(path, ("criterion",), dtype, units, long_name, values=values, open_ended=open_ended)


def _of_cell(name: str, dtype: str, units: str, long_name: str, values: Values = Values()) -> Dataset:
    return Dataset(
        f"/cell/{name}", ("variant", "criterion"), dtype, units, long_name, values=values, open_ended=dtype == "float"
    )


class TradeFile(FileKind):
    """Its datasets by name; `TRADE` is the kind of file."""

    TITLE = Dataset("/title", (), "str", "1", "title of the trade")
    VARIANT_NAME = _of_variant("name", "str", "variants", NAMES)
    VARIANT_TITLE = _of_variant("title", "str", "title of its project; empty where that cannot be read")
    VARIANT_DIFFERS = _of_variant("differs", "str", "what differs, in the words of the user")
    VARIANT_BUILD = _of_variant("build", "str", "its build folder, as seen from this file")
    VARIANT_FAILURE = _of_variant("failure", "str", "why its chain has no results; empty where it has")
    VARIANT_FRONT = _of_variant(
        "front", "int", "1 on the Pareto front, 2 where only those of front 1 dominate it, ...; 0: not compared", COUNT
    )
    VARIANT_SCORE = _of_variant(
        "score",
        "float",
        "weighted mean over the criteria with weights of how far it is from the best value to the worst; nan: none",
        open_ended=True,
    )
    DOMINATES = Dataset(
        "/variant/dominates",
        ("variant", "variant_column"),
        "int",
        "1",
        "1 where the variant of the row dominates that of the column",
        values=FLAG,
    )
    CRITERION_NAME = _of_criterion("name", "str", "criteria", NAMES)
    CRITERION_KIND = _of_criterion("kind", "str", "kind of the criterion in the configuration")
    CRITERION_WORDS = _of_criterion("words", "str", "what its value is")
    CRITERION_UNIT = _of_criterion("unit", "str", "unit of its values; empty where no variant has it")
    CRITERION_GOAL = _of_criterion("goal", "str", "what is better: less or more", Values(words=GOALS))
    CRITERION_LIMIT = _of_criterion(
        "limit",
        "float",
        "what values are judged by: at most this, or at least this where more is better; nan: not judged",
        units="see /criterion/unit",
        open_ended=True,
    )
    CRITERION_WEIGHT = _of_criterion("weight", "float", "weight in the score; 0: none")
    CRITERION_PARTS = _of_criterion("parts", "str", "what the parts are that contributors add; empty: no contributors")
    VALUE = _of_cell("value", "float", "see /criterion/unit", "value of the criterion; nan: the variant lacks it")
    REASON = _of_cell("reason", "str", "1", "why the variant lacks the criterion; empty where it does not")
    OF = _of_cell("of", "str", "1", "what the value is of: output, case, frequency")
    VERDICT = _of_cell("verdict", "str", "1", "verdict by the limit; empty: none", Values(words=(*JUDGED, NOT_JUDGED)))
    CONTRIBUTOR_VARIANT = Dataset(
        "/contributor/variant",
        ("contributor",),
        "int",
        "1",
        "variant that it contributes to",
        values=Values(rows_of="variant"),
    )
    CONTRIBUTOR_CRITERION = Dataset(
        "/contributor/criterion",
        ("contributor",),
        "int",
        "1",
        "criterion that it contributes to",
        values=Values(rows_of="criterion"),
    )
    CONTRIBUTOR_NAME = Dataset(
        "/contributor/name", ("contributor",), "str", "1", "thermal area, group, or source of noise"
    )
    CONTRIBUTOR_PART = Dataset(
        "/contributor/part",
        ("contributor",),
        "float",
        "see /criterion/parts",
        "its part, signed; of a ratio the parts sum to its square",
    )


TRADE = TradeFile("trade", 1, "tedm trade")
