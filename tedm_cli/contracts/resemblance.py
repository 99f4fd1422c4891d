"""What a case file says of the thermal network beside the assumed cases, and of the levels of its disturbances."""

from __future__ import annotations

from tedm_cli.contracts.spec import NAMES, Dataset, Values

_LEVEL = "level"


class ResemblanceDatasets:
    """Correlation and temperatures of the thermal nodes at /correlation/frequency, and those that cases assume."""

    RESEMBLANCE_CASE = Dataset(
        "/resemblance/case",
        ("assumed_case",),
        "str",
        "1",
        "cases of areas that are not diagnostic and leave no node silent, the most alike first",
        "",
        True,
        NAMES,
    )
    RESEMBLANCE_DEVIATION = Dataset(
        "/resemblance/deviation",
        ("assumed_case",),
        "float",
        "1",
        "root mean square over pairs of nodes of the difference of the correlations",
        optional=True,
        values=Values(least=0),
    )
    RESEMBLANCE_GROUP = Dataset(
        "/resemblance/group", ("node_group",), "str", "1", "groups of the thermal nodes", "", True, NAMES
    )
    RESEMBLANCE_COHERENCE = Dataset(
        "/resemblance/coherence",
        ("node_group", "node_group_column"),
        "float",
        "1",
        "mean size of the correlation over pairs of nodes, one in each group; NaN: no pair",
        optional=True,
        open_ended=True,
    )
    RESEMBLANCE_COMPUTED = Dataset(
        "/resemblance/computed",
        ("node_group", "node_group_column"),
        "float",
        "1",
        "mean real part of the correlation over these pairs; NaN: no pair",
        optional=True,
        open_ended=True,
    )
    RESEMBLANCE_ASSUMED = Dataset(
        "/resemblance/assumed",
        ("assumed_case", "node_group", "node_group_column"),
        "float",
        "1",
        "the same of the correlation that each case assumes for the areas of the nodes; NaN: no pair",
        optional=True,
        open_ended=True,
    )
    RESEMBLANCE_ASD = Dataset(
        "/resemblance/asd",
        ("node_group",),
        "float",
        "K/sqrt(Hz)",
        "root mean square of the temperatures of the nodes",
        optional=True,
    )
    RESEMBLANCE_ASSUMED_ASD = Dataset(
        "/resemblance/assumed_asd",
        ("node_group",),
        "float",
        "K/sqrt(Hz)",
        "the same of the temperatures that the cases assume for the areas of the nodes",
        optional=True,
    )
    DISTURBANCE_UNIT = Dataset(
        "/disturbance/unit",
        ("disturbance",),
        "str",
        "1",
        "unit of the disturbance before per sqrt(Hz); of a gradient area K/m",
        optional=True,
        values=Values(words=("K", "W", "K/m")),
        group=_LEVEL,
    )
    DISTURBANCE_LEVEL = Dataset(
        "/disturbance/level",
        ("disturbance", "frequency"),
        "float",
        None,
        "amplitude spectral density of the disturbance itself, in its unit per sqrt(Hz)",
        optional=True,
        group=_LEVEL,
    )
