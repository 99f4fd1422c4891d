"""Acceleration noise of imposed motion, as figure_6_2.h5 tells it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.contracts import IMPOSED
from tedm_cli.errors import InputError
from tedm_cli.files.store import Reader
from tedm_cli.results.cases.noise import Limit


@dataclass(frozen=True, eq=False)
class ImposedNoise:
    """One test mass of a model: ASDs [F] in m/s²/√Hz of all sources and of each alone, signed parts of the power.

    `ratio` : largest noise / requirement, without a safety factor; `binding_hz` : where.
    """

    model: str
    test_mass: str
    asd: FloatArray
    alone: dict[str, FloatArray]
    share: dict[str, float]
    ratio: float
    binding_hz: float


@dataclass(frozen=True, eq=False)
class ImposedMotion:
    """Positions of `motion` [F] (m/√Hz) on every test mass, the requirement, and the noise of every test mass.

    `level` : of the requirement, m/s²/√Hz, far below the frequencies at which it rises.
    """

    frequency_hz: FloatArray
    motion: FloatArray
    motion_source: str
    limit: Limit
    level: float
    noises: tuple[ImposedNoise, ...]


def read_imposed(file: Reader) -> ImposedMotion:
    """What an open file says; `InputError` where it tells of a test mass twice."""
    named = list(zip(file.strings(IMPOSED.ROW_MODEL), file.strings(IMPOSED.ROW_TEST_MASS), strict=True))
    for row, (model, name) in enumerate(named):
        if (model, name) in named[:row]:
            fact = f"{IMPOSED.ROW_TEST_MASS}: {name} of {model} is there twice"
            raise InputError(fact, where=str(file.path), hint=f"make it again with `{IMPOSED.made_by}`")
    f, sources = file.array(IMPOSED.FREQUENCY), file.strings(IMPOSED.SOURCE_NAME)
    limit = Limit(
        file.string(IMPOSED.REQUIREMENT_NAME),
        file.string(IMPOSED.REQUIREMENT_SOURCE),
        "m s^-2",
        (float(f[0]), float(f[-1])),
        file.array(IMPOSED.REQUIREMENT_AMPLITUDE),
    )
    rows = zip(
        named,
        file.array(IMPOSED.ASD),
        file.array(IMPOSED.ASD_ALONE),
        file.array(IMPOSED.SHARE),
        file.array(IMPOSED.RATIO),
        file.array(IMPOSED.BINDING_FREQUENCY),
        strict=True,
    )
    noises = tuple(
        ImposedNoise(
            model,
            name,
            asd,
            {s: a for s, a in zip(sources, alone, strict=True) if np.any(a)},
            {s: float(x) for s, x, a in zip(sources, share, alone, strict=True) if np.any(a)},
            float(ratio),
            float(binding),
        )
        for (model, name), asd, alone, share, ratio, binding in rows
    )
    return ImposedMotion(
        f,
        file.array(IMPOSED.MOTION_AMPLITUDE),
        file.string(IMPOSED.MOTION_SOURCE),
        limit,
        file.number(IMPOSED.REQUIREMENT_LEVEL),
        noises,
    )
