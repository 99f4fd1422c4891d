"""Verdicts on the field at rest: the field of every subsystem on every test mass, judged by what is configured."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.config.model.at_rest import rest_of
from tedm_cli.config.model.file import ModelConfig
from tedm_cli.contracts import SENSITIVITY
from tedm_cli.files.store import Writer
from tedm_cli.gravity.requirements import DcVerdict, judge_at_rest
from tedm_cli.results.gravity.at_rest import fields_at_rest


def verdicts_at_rest(
    config: ModelConfig,
    sources: Sequence[str],
    pulls: Mapping[str, FloatArray],
    by_area: Mapping[str, FloatArray],
    groups: Sequence[str],
    of_blocks: Mapping[str, Mapping[str, FloatArray]],
) -> list[DcVerdict]:
    """Judge the field at rest; parameters as `fields_at_rest` has them."""
    fields = fields_at_rest(config, sources, pulls, by_area, groups, of_blocks)
    return judge_at_rest(config.limits_at_rest(), fields, rest_of(config.gravity.subsystems))


def write_verdicts(writer: Writer, verdicts: Sequence[DcVerdict]) -> None:
    """The verdicts, a row for each."""
    kind = SENSITIVITY
    writer.write(kind.DC_VERDICT_TEST_MASS, [v.test_mass for v in verdicts])
    writer.write(kind.DC_VERDICT_MINUS, [v.minus for v in verdicts])
    writer.write(kind.DC_VERDICT_QUANTITY, [v.quantity for v in verdicts])
    writer.write(kind.DC_VERDICT_SUBSYSTEM, [v.subsystem for v in verdicts])
    writer.write(kind.DC_VERDICT_WHOLE, [int(v.whole) for v in verdicts])
    writer.write(kind.DC_VERDICT_REQUIREMENT, [v.requirement for v in verdicts])
    writer.write(kind.DC_VERDICT_SOURCE, [v.source for v in verdicts])
    writer.write(kind.DC_VERDICT_UNIT, [v.unit for v in verdicts])
    for path, values in (
        (kind.DC_VERDICT_VALUE, [v.value for v in verdicts]),
        (kind.DC_VERDICT_LOWER, [v.lower for v in verdicts]),
        (kind.DC_VERDICT_UPPER, [v.upper for v in verdicts]),
    ):
        writer.write(path, np.array(values, dtype=np.float64), units="see /dc_verdict/unit")
    writer.write(kind.DC_VERDICT_RATIO, np.array([v.ratio for v in verdicts], dtype=np.float64))
    writer.write(kind.DC_VERDICT_PASSED, np.array([v.passed for v in verdicts], dtype=np.int64))
