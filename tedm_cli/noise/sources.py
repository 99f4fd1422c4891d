"""What temperature noise may come from: spectra and correlations that are assumed, or a thermal network.

Both tell PSDs and cross-spectra of outputs, what each area makes of them, and what bounds them, by the same methods.
"""

from tedm_cli.noise.network import NetworkNoise, NetworkOutputs
from tedm_cli.noise.propagation import OutputNoise, TemperatureNoise

AnySource = TemperatureNoise | NetworkNoise
AnyNoise = OutputNoise | NetworkOutputs
