"""The linear system that makes the noise of a case, whatever its temperatures are from."""

from __future__ import annotations

from tedm_cli.arrays import FloatArray
from tedm_cli.noise.network import NetworkNoise
from tedm_cli.noise.shaping.network_model import NetworkModel, network_model
from tedm_cli.noise.shaping.state_space import NoiseModel, noise_model
from tedm_cli.noise.sources import AnySource

AnyModel = NoiseModel | NetworkModel


def model_of(
    rows: FloatArray, source: AnySource, band_hz: tuple[float, float], tolerance: float, where: str
) -> AnyModel:
    """The noise of outputs with `rows` [p, k] per kelvin; raises as `noise_model` and `network_model` do."""
    if isinstance(source, NetworkNoise):
        return network_model(rows, source, band_hz, tolerance, where)
    return noise_model(rows, source, band_hz, tolerance, where)
