"""A realisation in 78 areas, against the random numbers alone that it takes: it cannot be quicker than these."""

from __future__ import annotations

import tracemalloc

import numpy as np

from benchmarks.timing import Result, timed

SAMPLES = 1_000_000


def realisation(independent: int = 78, samples: int = SAMPLES) -> Result:
    """Case of `independent` blocks for 24 outputs at 0.25 Hz, spectra from 1 mHz on."""
    from tedm_cli.noise.areas import AreaTable
    from tedm_cli.noise.correlation import Correlation
    from tedm_cli.noise.propagation import TemperatureNoise
    from tedm_cli.noise.realisation import Plan, realise, resolved
    from tedm_cli.noise.temperature import thesis_model

    k = 78
    shield = np.where(np.arange(k) < 12, "outside", "inside")
    areas = AreaTable(name=np.array([f"A{i}" for i in range(k)]), group=shield, shield=shield, side=np.full(k, "mid"))
    model, rows = thesis_model(areas), np.random.default_rng(3).normal(size=(24, k))
    factor = np.eye(independent)[np.arange(k) % independent]
    source = TemperatureNoise(model, Correlation.of_factor(factor))
    plan = Plan(rate_hz=0.25, samples=samples, seed=1, low_hz=1e-4, high_hz=0.1, lowest_hz=1e-3)
    notes = []

    def work() -> None:
        estimate = realise(rows, source, plan)
        band = resolved(estimate.frequency_hz, plan)
        ratio = estimate.psd[:, band] / source.psd(rows, estimate.frequency_hz[band])
        notes.append(f"mean ratio to exact {ratio.mean(axis=1).min():.4f} to {ratio.mean(axis=1).max():.4f}")

    def peer() -> None:
        rng = np.random.default_rng(1)
        block = 100_000
        for _ in range(samples // block):
            rng.standard_normal((independent, block))

    done = timed(work, peer, runs=2)
    tracemalloc.start()
    realise(rows, source, Plan(0.25, 200_000, 1, 1e-4, 0.1, 1e-3))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return Result(done.ours, done.peer, f"{notes[-1]}; peak memory {peak / 1e6:.0f} MB at any length")
