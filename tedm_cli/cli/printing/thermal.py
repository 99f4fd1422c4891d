"""The thermal network, as lines of text and for programs."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from tedm_cli.cli.printing.table import table
from tedm_cli.results.wording import and_text, count

if TYPE_CHECKING:
    from tedm_cli.results.thermal.file import DisturbanceResults, Spread, SteadyResults, ThermalResults
    from tedm_cli.stages.thermal.build import ThermalSummary

_GAINS = 2  # of each disturbance
_UNIT = {"temperature": "K/K", "power": "K/W"}


def thermal_lines(done: ThermalSummary) -> list[str]:
    """Nodes, steady state, and of every disturbance the largest gains and the low-pass that fits them."""
    lines = result_lines(done.results)
    return [f"{done.path}: {lines[0]}", *lines[1:], *done.notes, f"made in {done.seconds:.3g} s"]


def result_lines(r: ThermalResults) -> list[str]:
    """The same of a file that is there."""
    lines = [] if r.steady is None else _steady_lines(r.steady)
    if r.mapped:
        outputs = f"; {count(r.outputs, 'output')} per kelvin of each" if r.outputs else ""
        lines.append(f"{count(len(r.mapped), 'thermal node')} on the model{outputs}")
    if r.steady is not None and not r.disturbances:
        lines.append("nothing disturbs it: there are no gains and no spectra")
    if r.frequencies is not None:
        number, low, high = r.frequencies
        spectra = "spectra of them all" if r.spectra else "no spectra: these are too many nodes, name some in [output]"
        lines.append(
            f"gains of {count(r.kept, 'node')} at {number:,} frequencies from {low:g} to {high:g} Hz; {spectra}"
        )
    if (c := r.coherence) is not None:
        lines.append(
            f"coherence of two nodes at {1e3 * c.frequency_hz:g} mHz: median {c.median:.3g}, least {c.least:.3g}"
            f" ({and_text(c.pair)})"
        )
    if r.disturbances:
        head = ("disturbance", "largest gains for f to 0", "order", "corner mHz", "beyond", "fit error")
        lines += table(head, [_row(d) for d in r.disturbances], right=(4, 5))
        lines += [
            "order, corner: median and range over the nodes of the low-pass 1/sqrt(1 + (f/fc)^2n) that fits each gain",
            "beyond: nodes whose corner is not near the frequencies; fit error: median of the rms of ln(fit/gain)",
        ]
    return lines


def _steady_lines(s: SteadyResults) -> list[str]:
    kinds = and_text([f"{n} {kind}" for kind, n in s.count.items() if n])
    lines = [
        f"{count(sum(s.count.values()), 'node')} ({kinds}), {count(s.conductors, 'conductor')}",
        f"steady state: coldest {s.coldest[0]} {s.coldest[1]:.6g} K, hottest {s.hottest[0]} {s.hottest[1]:.6g} K",
        f"energy balance: powers {s.power_W:.6g} W, boundaries take {s.to_boundaries_W:.6g} W",
    ]
    if s.solved:
        lines[-1] += f"; largest imbalance of {count(s.solved, 'node')} solved for {s.imbalance_W:.1e} W"
    if s.given:
        lines[-1] += f"; of {count(s.given, 'node')} given {s.held_W:.3g} W ({s.held})"
    return lines


def _row(d: DisturbanceResults) -> tuple[str, ...]:
    largest = ", ".join(f"{node} {gain:.3g}" for node, gain in d.largest[:_GAINS])
    return (
        d.name,
        f"{largest} {_UNIT[d.kind]}",
        _spread(d.order, 1.0),
        _spread(d.corner_hz, 1e3),
        str(d.beyond),
        "-" if d.error is None else f"{d.error:.2g}",
    )


def _spread(s: Spread | None, factor: float) -> str:
    return "-" if s is None else f"{factor * s.median:.3g} ({factor * s.low:.3g} to {factor * s.high:.3g})"


def thermal_dict(done: ThermalSummary) -> dict[str, Any]:
    """What a program needs."""
    return {"file": done.path, **asdict(done.results), "notes": done.notes, "seconds": done.seconds}
