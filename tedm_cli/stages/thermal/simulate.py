"""simulate-thermal: the thermal network stepped in time, by given disturbances or by realisations of their spectra."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.config.project import Project
from tedm_cli.config.thermal.file import ThermalConfig, load_thermal
from tedm_cli.contracts import THERMAL as KIND
from tedm_cli.errors import ConfigError, InputError, UsageError
from tedm_cli.files.build_folder import THERMAL_FILE
from tedm_cli.files.store import open_checked
from tedm_cli.noise.realisation import Plan
from tedm_cli.progress import Step, counter
from tedm_cli.quantities import DURATION
from tedm_cli.results.thermal.disturbed_network import DisturbedNetwork, read_network
from tedm_cli.results.thermal.file import require_network
from tedm_cli.results.thermal.nodes import REBUILD
from tedm_cli.stages.thermal.disturbances import given_disturbances, realised_disturbances
from tedm_cli.stages.thermal.node_table import Write, node_table, require_format
from tedm_cli.stages.thermal.spectra_check import CheckedNodes, SpectraCheck, lowest_checked_hz
from tedm_cli.thermal.stepping import NetworkInTime, slowest_s

_PER_PERIOD = 5.0  # samples in a period of the highest frequency
_SETTLE = 6.0  # slowest time constants that a realisation runs before its first sample
_MOST_SAMPLES = 100_000_000
_MOST_NUMBERS = 250_000_000  # of a table: 2 GB


@dataclass(frozen=True)
class Realise:
    """A realisation: its length, step (None: a fifth of a period of the highest frequency) and seed."""

    duration_s: float
    step_s: float | None
    seed: int


@dataclass(frozen=True, eq=False)
class InTime:
    """A network in time, its temperatures about the steady state.

    Parameters
    ----------
    output : the table that was written. source : of the disturbances; None of a realisation with `seed`.
    disturbance, kind, rms, peak : [u] of the disturbances, K or W. constant : those that have no column.
    node, steady_K, node_rms, node_peak, error_K : [n] of all free nodes; exact : whether steps are.
    columns : number of nodes in the table. boundary_peak : largest change of a boundary over its temperature.
    settled_s : what ran before the first sample; slowest_s : slowest time constant.
    radiates : whether there is radiation. check : of a realisation; None where it is too short.
    """

    output: Path | None
    source: Path | None
    seed: int
    samples: int
    first_s: float
    step_s: float
    disturbance: list[str]
    kind: list[str]
    rms: FloatArray
    peak: FloatArray
    constant: list[str]
    node: tuple[str, ...]
    steady_K: FloatArray
    node_rms: FloatArray
    node_peak: FloatArray
    error_K: FloatArray
    exact: bool
    columns: int
    boundary_peak: float
    settled_s: float
    slowest_s: float
    radiates: bool
    check: SpectraCheck | None

    @property
    def largest_change(self) -> float:
        """The largest change of a temperature over that of the steady state."""
        return max(float((self.node_peak / self.steady_K).max()), self.boundary_peak)

    @property
    def nonlinear(self) -> float:
        """Upper bound, relative to a change of temperature, of the radiated heat that is left out: of T⁴ about T."""
        x = self.largest_change
        return 1.5 * x + x**2 + 0.25 * x**3 if self.radiates else 0.0


def simulate_thermal(
    project: Project, given: Path | None, realise: Realise | None, output: Path | None, step: Step
) -> InTime:
    """Step the network of thermal.h5 by the disturbances of a table, or by a realisation.

    Raises
    ------
    UsageError : a name of a file that says no format, or that is read; numbers that are implausible.
    ConfigError : no thermal model, or one without network or disturbances.
    InputError : thermal.h5 is missing or stale; a table that is refused; too many samples.
    """
    require_format(output)
    where = project.required_thermal()
    config = load_thermal(where)[1]
    _require_other(output, [where, *(project.beside(where, name) for name in config.file_names()), given])
    if lacking := [
        n for n, there in (("[network]", config.network), ("[[disturbance]]", config.disturbances)) if not there
    ]:
        raise ConfigError([("", f"has no {' and no '.join(lacking)}: nothing moves in time")], where=str(where))
    path = project.build_dir / THERMAL_FILE
    if not path.exists():
        raise InputError("no such file; the network is taken from it", where=str(path), hint=f"make it with {REBUILD}")
    with open_checked(path, KIND) as file:
        require_network(file, project, config)
        if not file.has(KIND.TRANSFER):
            raise InputError("has no gains", where=str(path), hint=f"rebuild it with {REBUILD}")
        found = read_network(file)
    if given is not None:
        with given_disturbances(given, found.disturbance, found.kind) as table:
            stepping = _Stepping(found, NetworkInTime(found.linear, table.step_s), None)
            with node_table(output, stepping.columns) as write:
                for block in table.blocks:
                    stepping.add(block, table.first_s, table.step_s, write)
            return stepping.result(output, given, 0, table.first_s, table.step_s, table.constant, 0.0)
    if realise is None:
        hint = "tedm simulate-thermal disturbances.csv, or tedm simulate-thermal --duration 1e6"
        raise UsageError("name a file of disturbances, or the --duration of a realisation", hint=hint)
    return _realised(project, config, found, realise, output, step)


def _require_other(output: Path | None, read: Sequence[Path | None]) -> None:
    """Refuse to write over what is read."""
    if output is not None and output.resolve() in [path.resolve() for path in read if path is not None]:
        raise UsageError(f"-o {output}: is a file that is read", hint="name another")


def _realised(
    project: Project, config: ThermalConfig, found: DisturbedNetwork, realise: Realise, output: Path | None, step: Step
) -> InTime:
    where = project.required_thermal()
    high = float(found.frequency_hz[-1])
    step_s = realise.step_s if realise.step_s is not None else 1.0 / (_PER_PERIOD * high)
    for option, value in (("--duration", realise.duration_s), ("--step", step_s)):
        if fact := DURATION.fact(value):
            raise UsageError(f"{option}: {fact}")
    if 0.5 / step_s <= high:
        hint = f"at most {0.5 / high:.3g} s; by default it is {1.0 / (_PER_PERIOD * high):.3g} s"
        raise UsageError(
            f"--step {step_s:g} s is too long for the frequencies of {where}, up to {high:g} Hz", hint=hint
        )
    samples = int(realise.duration_s / step_s * (1.0 + 1e-12)) + 1
    slowest = slowest_s(found.linear)
    before = int(np.ceil(min(_SETTLE * slowest, realise.duration_s) / step_s))
    columns = len(found.kept) + int(found.network.boundary.sum())
    if samples + before > _MOST_SAMPLES or (output is not None and samples * columns > _MOST_NUMBERS):
        raise InputError(
            f"{samples:,} samples of {columns} nodes and {before:,} before them are too many; at most {_MOST_SAMPLES:,}"
            f" are made, and {_MOST_NUMBERS:,} numbers written",
            where=str(where),
            hint="take a shorter --duration or a longer --step",
        )
    lowest = lowest_checked_hz(samples, 1.0 / step_s, found.frequency_hz)
    filtered = lowest if lowest is not None else min(max(8.0 / realise.duration_s, float(found.frequency_hz[0])), high)
    plan = Plan(1.0 / step_s, samples + before, realise.seed, float(found.frequency_hz[0]), high, filtered)
    checked = None if lowest is None else CheckedNodes(found, plan)
    stepping = _Stepping(found, NetworkInTime(found.linear, step_s, settled=False), checked)
    spectra = [d.own_spectrum(lambda name: project.beside(where, name)) for d in config.disturbances]
    advance = counter(step, plan.samples, "stepping the network")
    try:
        with node_table(output, stepping.columns) as write:
            for block in _after(
                realised_disturbances(spectra, found.factor, found.frequency_hz, plan), stepping, before
            ):
                stepping.add(block, 0.0, step_s, write)
                advance(block.shape[1])
    except InputError as error:
        if error.where != "realisation":
            raise
        raise InputError(error.fact, where=str(where), hint="take a longer --step or a shorter --duration") from error
    return stepping.result(output, None, realise.seed, 0.0, step_s, [], before * step_s, slowest)


def _after(blocks: Iterator[FloatArray], stepping: _Stepping, before: int) -> Iterator[FloatArray]:
    """The blocks behind the first samples, which the network is only led through."""
    for block in blocks:
        lead = min(before, block.shape[1])
        before -= lead
        if lead:
            stepping.lead(block[:, :lead])
        if lead < block.shape[1]:
            yield block[:, lead:]


class _Stepping:
    """The network, and what is kept of its temperatures."""

    def __init__(self, found: DisturbedNetwork, network: NetworkInTime, checked: CheckedNodes | None) -> None:
        self._found, self._network, self._checked = found, network, checked
        n, u = len(found.linear.name), len(found.disturbance)
        self._square, self._peak, self._samples = np.zeros(n), np.zeros(n), 0
        self._u_square, self._u_peak = np.zeros(u), np.zeros(u)
        fixed = [found.network.name[row] for row in np.flatnonzero(found.network.boundary)]
        self.columns = [*(found.linear.name[row] for row in found.kept), *fixed]
        self._fixed_peak = np.zeros(len(fixed))

    def lead(self, u: FloatArray) -> None:
        """Step through disturbances [u, T] of which nothing is kept."""
        self._network.advance(u)

    def add(self, u: FloatArray, first_s: float, step_s: float, write: Write) -> None:
        """Step through disturbances [u, T] and write what becomes of them."""
        temperature, fixed = self._network.advance(u), self._found.boundary_share @ u
        if self._checked is not None:
            self._checked.add(temperature)
        time = first_s + step_s * np.arange(self._samples, self._samples + u.shape[1])
        write(time, np.concatenate([temperature[self._found.kept], fixed]))
        self._samples += u.shape[1]
        self._square += np.sum(temperature**2, axis=1)
        self._u_square += np.sum(u**2, axis=1)
        for peak, values in ((self._peak, temperature), (self._u_peak, u), (self._fixed_peak, fixed)):
            np.maximum(peak, np.abs(values).max(axis=1), out=peak)

    def result(
        self,
        output: Path | None,
        source: Path | None,
        seed: int,
        first_s: float,
        step_s: float,
        constant: list[str],
        settled_s: float,
        slowest: float | None = None,
    ) -> InTime:
        found, n = self._found, self._samples
        boundary = found.network.boundary
        return InTime(
            output, source, seed, n, first_s, step_s, found.disturbance, found.kind,
            np.sqrt(self._u_square / n), self._u_peak, constant, found.linear.name, found.steady_K[~boundary],
            np.sqrt(self._square / n), self._peak, self._network.error_K, self._network.exact, len(self.columns),
            float(np.max(self._fixed_peak / found.steady_K[boundary], initial=0.0)), settled_s,
            slowest if slowest is not None else slowest_s(found.linear), bool(found.network.radiative.any()),
            None if self._checked is None else self._checked.check(),
        )  # fmt: skip
