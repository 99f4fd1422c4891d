"""How sure the verdicts of a case are: datasets of its file, there where the configuration has uncertainties."""

from __future__ import annotations

from tedm_cli.contracts.spec import COUNT, NAMES, Dataset, Values

QUANTITIES = ("expansion", "modulus", "density", "thickness", "position", "level", "mesh")
DISTRIBUTIONS = ("normal", "uniform", "lognormal")
MEASURES = ("standard deviation", "half width")
_MESH = "uncertainty by the mesh"  # there where a second mesh is


def _of(
    path: str,
    dims: tuple[str, ...],
    dtype: str,
    units: str | None,
    long_name: str,
    values: Values = Values(),
    group: str = "",
) -> Dataset:
    return Dataset(f"/uncertainty/{path}", dims, dtype, units, long_name, optional=True, values=values, group=group)


class UncertaintyDatasets:
    """Parameters with their deviations, and what they make of every verdict.

    Probabilities are of the temperature noise as the case has it: what is uncertain is the model, not the noise.
    """

    UNCERTAIN_NAME = _of("parameter/name", ("parameter",), "str", "1", "uncertain parameters", NAMES)
    UNCERTAIN_QUANTITY = _of(
        "parameter/quantity", ("parameter",), "str", "1", "what is uncertain", Values(words=QUANTITIES)
    )
    UNCERTAIN_OF = _of("parameter/of", ("parameter",), "str", "1", "of which materials, properties, test mass or areas")
    UNCERTAIN_DEVIATION = _of(
        "parameter/deviation",
        ("parameter",),
        "float",
        None,
        "one standard deviation, or half the width, in /uncertainty/parameter/unit",
    )
    UNCERTAIN_MEASURE = _of(
        "parameter/measure", ("parameter",), "str", "1", "which of the two the deviation is", Values(words=MEASURES)
    )
    UNCERTAIN_UNIT = _of(
        "parameter/unit",
        ("parameter",),
        "str",
        "1",
        "unit of the deviation; 1: relative, of lognormal parameters of the logarithm",
        Values(words=("1", "1/K", "m")),
    )
    UNCERTAIN_DISTRIBUTION = _of(
        "parameter/distribution", ("parameter",), "str", "1", "its distribution", Values(words=DISTRIBUTIONS)
    )
    UNCERTAIN_SOURCE = _of("parameter/source", ("parameter",), "str", "1", "where the deviation is from")
    UNCERTAIN_BLOCK = _of(
        "parameter/block",
        ("parameter",),
        "int",
        "1",
        "the independent source that the parameter belongs to",
        Values(rows_of="source"),
    )
    UNCERTAIN_CORRELATION = _of(
        "parameter/correlation",
        ("parameter", "parameter_column"),
        "float",
        "1",
        "correlation of the normal variables behind the parameters (Gaussian copula)",
    )
    SOURCE_OF_VARIANCE = _of(
        "source/name",
        ("source",),
        "str",
        "1",
        "independent sources: a parameter, or all that are correlated with each other",
        NAMES,
    )
    LEFT_OUT = Dataset(
        "/uncertainty/left_out",
        ("left_out",),
        "str",
        "1",
        "what is configured and could not be propagated, and why; absent where nothing is",
        optional=True,
        group="/uncertainty/left_out",
    )
    UNCERTAINTY_SAMPLES = _of("samples", (), "int", "1", "draws of all parameters together", COUNT)
    UNCERTAINTY_SHARE_SAMPLES = _of(
        "share_samples",
        (),
        "int",
        "1",
        "draws behind the shares of variance, twice and for each source once more",
        COUNT,
    )
    UNCERTAINTY_SEED = _of("seed", (), "int", "1", "seed of the random numbers", COUNT)
    UNCERTAINTY_NOMINAL = _of(
        "nominal", ("verdict",), "float", "1", "ratio without deviations: that of the verdict itself"
    )
    UNCERTAINTY_MEAN = _of("mean", ("verdict",), "float", "1", "mean of the ratio, with the safety factor")
    UNCERTAINTY_DEVIATION = _of("deviation", ("verdict",), "float", "1", "standard deviation of the ratio")
    UNCERTAINTY_PROBABILITY = _of("probability", ("probability",), "float", "1", "probabilities of the quantiles")
    UNCERTAINTY_QUANTILE = _of(
        "quantile", ("verdict", "probability"), "float", "1", "quantiles of the ratio, with the safety factor"
    )
    VIOLATED = _of(
        "violated",
        ("verdict", "factor", "estimate"),
        "float",
        "1",
        "probability that the ratio is above 1, with the safety factor and with 1 in its place; its standard error by"
        " the number of draws, at most, and its interval of 95 % confidence (Wilson)",
    )
    SHARE_FIRST = _of(
        "share_first", ("verdict", "source"), "float", "1", "share of the ratio's variance by each source alone"
    )
    SHARE_TOTAL = _of(
        "share_total",
        ("verdict", "source"),
        "float",
        "1",
        "share with all its interactions: of the variance that stays when all others are known",
    )
    UNCERTAIN_OUTPUT = _of("output/label", ("judged_output",), "str", "1", "outputs that are judged", NAMES)
    OUTPUT_VIOLATED = _of(
        "output/violated",
        ("judged_output", "factor", "estimate"),
        "float",
        "1",
        "the same, that any of its requirements is violated",
    )
    ANY_VIOLATED = _of(
        "any/violated", ("factor", "estimate"), "float", "1", "the same, that any verdict of the case is a violation"
    )
    MESH_OTHER = _of("mesh/other", (), "str", "1", "build folder of the other mesh", group=_MESH)
    MESH_REFINEMENT = _of(
        "mesh/refinement", (), "float", "1", "size of its elements over that of this mesh's", group=_MESH
    )
    MESH_ORDER = _of("mesh/order", (), "float", "1", "order by which the error falls with the size", group=_MESH)
    MESH_OTHER_RATIO = _of("mesh/other_ratio", ("verdict",), "float", "1", "ratio by the other mesh", group=_MESH)
    MESH_EXTRAPOLATED_RATIO = _of(
        "mesh/extrapolated_ratio",
        ("verdict",),
        "float",
        "1",
        "ratio at elements without size, by both meshes (Richardson)",
        group=_MESH,
    )
