"""How sure the verdicts of a case are, in its file: written by `run-case`, read for prints, figures and the report.

`CaseUncertainty` and its parts are of the room that finds them, `tedm_cli.uncertainty.verdicts`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.contracts import CASE
from tedm_cli.errors import InputError, PhysicsError
from tedm_cli.files.store import Reader, Writer
from tedm_cli.uncertainty.parameters import Parameter, Parameters
from tedm_cli.uncertainty.verdicts import (
    PROBABILITIES,
    CaseUncertainty,
    Chance,
    Distribution,
    Draws,
    JudgedChance,
    MeshComparison,
)


def write_uncertainty(writer: Writer, u: CaseUncertainty) -> None:
    """Put it into a case file, whose verdicts are its verdicts."""
    p, v = u.parameters, u.verdicts
    writer.write(CASE.UNCERTAIN_NAME, [item.name for item in p.items])
    writer.write(CASE.UNCERTAIN_QUANTITY, [item.quantity for item in p.items])
    writer.write(CASE.UNCERTAIN_OF, [item.of for item in p.items])
    deviations = np.array([item.deviation for item in p.items], dtype=np.float64)
    writer.write(CASE.UNCERTAIN_DEVIATION, deviations, units="see /uncertainty/parameter/unit")
    writer.write(CASE.UNCERTAIN_MEASURE, [item.measure for item in p.items])
    writer.write(CASE.UNCERTAIN_UNIT, [item.unit for item in p.items])
    writer.write(CASE.UNCERTAIN_DISTRIBUTION, [item.distribution for item in p.items])
    writer.write(CASE.UNCERTAIN_SOURCE, [item.source for item in p.items])
    writer.write(CASE.UNCERTAIN_BLOCK, p.block)
    writer.write(CASE.UNCERTAIN_CORRELATION, p.correlation)
    writer.write(CASE.SOURCE_OF_VARIANCE, p.sources)
    if u.left_out:
        writer.write(CASE.LEFT_OUT, list(u.left_out))
    writer.write(CASE.UNCERTAINTY_SAMPLES, u.draws.samples)
    writer.write(CASE.UNCERTAINTY_SHARE_SAMPLES, 2**u.draws.share_power)
    writer.write(CASE.UNCERTAINTY_SEED, u.draws.seed)
    writer.write(CASE.UNCERTAINTY_NOMINAL, np.array([d.nominal for d in v]))
    writer.write(CASE.UNCERTAINTY_MEAN, np.array([d.mean for d in v]))
    writer.write(CASE.UNCERTAINTY_DEVIATION, np.array([d.deviation for d in v]))
    writer.write(CASE.UNCERTAINTY_PROBABILITY, PROBABILITIES)
    writer.write(CASE.UNCERTAINTY_QUANTILE, _table([d.quantile for d in v], len(PROBABILITIES)))
    chances = np.array([[_estimate(d.violated), _estimate(d.violated_bare)] for d in v])
    writer.write(CASE.VIOLATED, chances.reshape(len(v), 2, 4))
    writer.write(CASE.SHARE_FIRST, _table([d.share_first for d in v], len(p.sources)))
    writer.write(CASE.SHARE_TOTAL, _table([d.share_total for d in v], len(p.sources)))
    writer.write(CASE.UNCERTAIN_OUTPUT, [o.output for o in u.outputs])
    of_output = np.array([[_estimate(o.violated), _estimate(o.violated_bare)] for o in u.outputs])
    writer.write(CASE.OUTPUT_VIOLATED, of_output.reshape(len(u.outputs), 2, 4))
    writer.write(CASE.ANY_VIOLATED, np.array([_estimate(u.any_violated), _estimate(u.any_violated_bare)]))
    if u.mesh is not None:
        writer.write(CASE.MESH_OTHER, u.mesh.other)
        writer.write(CASE.MESH_REFINEMENT, u.mesh.refinement)
        writer.write(CASE.MESH_ORDER, u.mesh.order)
        writer.write(CASE.MESH_OTHER_RATIO, u.mesh.other_ratio)
        writer.write(CASE.MESH_EXTRAPOLATED_RATIO, u.mesh.extrapolated_ratio)


def read_uncertainty(file: Reader) -> CaseUncertainty | None:
    """How sure the verdicts of an open case file are; None where nothing is configured to be uncertain.

    Raises
    ------
    InputError : correlations that cannot be, or sources that are not theirs.
    """
    if not file.has(CASE.UNCERTAIN_NAME):
        return None
    texts = (
        CASE.UNCERTAIN_NAME,
        CASE.UNCERTAIN_QUANTITY,
        CASE.UNCERTAIN_OF,
        CASE.UNCERTAIN_DISTRIBUTION,
        CASE.UNCERTAIN_UNIT,
        CASE.UNCERTAIN_SOURCE,
    )
    deviations = file.array(CASE.UNCERTAIN_DEVIATION).tolist()
    items = tuple(
        Parameter(name, quantity, of, deviation, distribution, unit, source)
        for deviation, name, quantity, of, distribution, unit, source in zip(
            deviations, *(file.strings(text) for text in texts), strict=True
        )
    )
    try:
        parameters = Parameters(items, file.array(CASE.UNCERTAIN_CORRELATION))
    except PhysicsError as error:
        raise InputError(f"{CASE.UNCERTAIN_CORRELATION}: {error.fact}", where=str(file.path)) from None
    if parameters.sources != file.strings(CASE.SOURCE_OF_VARIANCE):
        fact = f"{CASE.SOURCE_OF_VARIANCE} are not those of {CASE.UNCERTAIN_CORRELATION}"
        raise InputError(fact, where=str(file.path), hint="run the case again")
    pairs = zip(file.strings(CASE.VERDICT_OUTPUT), file.strings(CASE.VERDICT_REQUIREMENT), strict=True)
    nominal, mean, deviation = (
        file.array(p).tolist() for p in (CASE.UNCERTAINTY_NOMINAL, CASE.UNCERTAINTY_MEAN, CASE.UNCERTAINTY_DEVIATION)
    )
    violated, quantile = file.array(CASE.VIOLATED), file.array(CASE.UNCERTAINTY_QUANTILE)
    first, total = file.array(CASE.SHARE_FIRST), file.array(CASE.SHARE_TOTAL)
    of_output, of_any = file.array(CASE.OUTPUT_VIOLATED), file.array(CASE.ANY_VIOLATED)
    return CaseUncertainty(
        parameters=parameters,
        left_out=tuple(file.strings(CASE.LEFT_OUT)) if file.has(CASE.LEFT_OUT) else (),
        draws=Draws(
            int(file.number(CASE.UNCERTAINTY_SAMPLES)),
            int(file.number(CASE.UNCERTAINTY_SEED)),
            int(file.number(CASE.UNCERTAINTY_SHARE_SAMPLES)).bit_length() - 1,
        ),
        verdicts=tuple(
            Distribution(
                output=output,
                requirement=requirement,
                nominal=nominal[v],
                violated=_chance(violated[v, 0]),
                violated_bare=_chance(violated[v, 1]),
                mean=mean[v],
                deviation=deviation[v],
                quantile=quantile[v],
                share_first=first[v],
                share_total=total[v],
            )
            for v, (output, requirement) in enumerate(pairs)
        ),
        outputs=tuple(
            JudgedChance(output, _chance(of_output[o, 0]), _chance(of_output[o, 1]))
            for o, output in enumerate(file.strings(CASE.UNCERTAIN_OUTPUT))
        ),
        any_violated=_chance(of_any[0]),
        any_violated_bare=_chance(of_any[1]),
        mesh=_read_mesh(file),
    )


def _read_mesh(file: Reader) -> MeshComparison | None:
    if not file.has(CASE.MESH_OTHER):
        return None
    return MeshComparison(
        file.string(CASE.MESH_OTHER),
        file.number(CASE.MESH_REFINEMENT),
        file.number(CASE.MESH_ORDER),
        file.array(CASE.MESH_OTHER_RATIO),
        file.array(CASE.MESH_EXTRAPOLATED_RATIO),
    )


def _estimate(chance: Chance) -> tuple[float, float, float, float]:
    return chance.probability, chance.error, chance.low, chance.high


def _chance(values: FloatArray) -> Chance:
    probability, error, low, high = (float(value) for value in values)
    return Chance(probability, error, low, high)


def _table(rows: Sequence[FloatArray], columns: int) -> FloatArray:
    """Rows as a table, which has its columns where there is no row."""
    return np.array(rows, dtype=np.float64).reshape(len(rows), columns)


def as_dict(u: CaseUncertainty | None) -> dict[str, Any] | None:
    """What a program needs of it; None where nothing is uncertain."""
    if u is None:
        return None
    verdicts = [
        {
            "output": d.output,
            "requirement": d.requirement,
            "nominal": d.nominal,
            "violated": _chance_dict(d.violated),
            "violated_without_factor": _chance_dict(d.violated_bare),
            "mean": d.mean,
            "deviation": d.deviation,
            "percentiles": {str(percent): d.percentile(percent) for percent in (5, 50, 95)},
            "shares": [
                {"source": source, "first": float(first), "total": float(total)}
                for source, first, total in zip(u.sources, d.share_first, d.share_total, strict=True)
            ],
        }
        for d in u.verdicts
    ]
    found: dict[str, Any] = {
        "parameters": [
            {
                "name": item.name,
                "quantity": item.quantity,
                "of": item.of,
                "deviation": item.deviation,
                "measure": item.measure,
                "unit": item.unit,
                "distribution": item.distribution,
                "source": item.source,
            }
            for item in u.parameters.items
        ],
        "left_out": list(u.left_out),
        "samples": u.draws.samples,
        "seed": u.draws.seed,
        "verdicts": verdicts,
        "outputs": [
            {
                "output": o.output,
                "violated": _chance_dict(o.violated),
                "violated_without_factor": _chance_dict(o.violated_bare),
            }
            for o in u.outputs
        ],
        "any_violated": _chance_dict(u.any_violated),
        "any_violated_without_factor": _chance_dict(u.any_violated_bare),
    }
    if u.mesh is not None:
        found["mesh"] = {
            "other": u.mesh.other,
            "refinement": u.mesh.refinement,
            "order": u.mesh.order,
            "other_ratio": u.mesh.other_ratio.tolist(),
            "extrapolated_ratio": u.mesh.extrapolated_ratio.tolist(),
        }
    return found


def _chance_dict(chance: Chance) -> dict[str, float]:
    return {
        "probability": chance.probability,
        "standard_error": chance.error,
        "low": chance.low,
        "high": chance.high,
    }
