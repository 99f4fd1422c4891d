"""build-adjoint: how far the areas are from an even temperature field, over its correlation length."""

from __future__ import annotations

import numpy as np

from tedm_cli.adjoint.area_points import area_points
from tedm_cli.adjoint.areas import Temperatures
from tedm_cli.adjoint.temperature_field import AreaError, area_error
from tedm_cli.arrays import FloatArray
from tedm_cli.contracts import ADJOINT
from tedm_cli.files.store import Writer
from tedm_cli.progress import Step
from tedm_cli.stages.adjoint.model import WarmedModel

MOST_POINTS = 10_000  # two seconds of processor time; it grows with their square: a minute and a half for 66,000
LENGTHS_M = (0.02, 0.05, 0.1, 0.2, 0.5, 1.0)


def even_field_error(
    of: Temperatures, direct: FloatArray, model: WarmedModel, step: Step, *, however_many: bool
) -> AreaError | None:
    """Of a field of one amplitude everywhere; None of a model of many points, unless it is asked for all the same.

    Parameters
    ----------
    direct : [r, k], of the outputs, what does not pass through the structure.
    """
    found = area_points(of, direct, model.areas, model.places)
    if len(found.area) > MOST_POINTS and not however_many:
        return None
    return area_error(found.points, found.area, LENGTHS_M, step)


def write_error(writer: Writer, error: AreaError) -> None:
    """Into adjoint.h5."""
    writer.write(ADJOINT.FIELD_LENGTH, np.array(LENGTHS_M))
    writer.write(ADJOINT.FIELD_RATIO, error.ratio)
    writer.write(ADJOINT.FIELD_LEFT_OUT, error.difference)
