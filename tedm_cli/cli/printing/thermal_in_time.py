"""The thermal network in time, as lines of text and for programs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from tedm_cli.cli.printing.table import table
from tedm_cli.results.wording import count

if TYPE_CHECKING:
    from tedm_cli.stages.thermal.simulate import InTime
    from tedm_cli.stages.thermal.spectra_check import SpectraCheck

_UNIT = {"temperature": "K", "power": "W"}


def in_time_lines(r: InTime, top: int | None) -> list[str]:
    """What was stepped and how, the nodes that move most, and how spectra compare."""
    source = f"disturbances of {r.source}" if r.source is not None else f"disturbances realised, seed {r.seed}"
    lines = [
        f"{source}: {r.samples:,} samples of {r.step_s:.6g} s over {(r.samples - 1) * r.step_s:.6g} s; slowest time"
        f" constant {r.slowest_s:.4g} s" + (f", {r.settled_s:.4g} s run before" if r.settled_s else ""),
        *table(
            ("disturbance", "rms", "peak", "unit"),
            [
                (name, *("constant",) * 2, _UNIT[kind]) if name in r.constant
                else (name, f"{rms:.3g}", f"{peak:.3g}", _UNIT[kind])
                for name, kind, rms, peak in zip(r.disturbance, r.kind, r.rms, r.peak, strict=True)
            ],
            right=(1, 2),
        ),
    ]  # fmt: skip
    order = _order(r, top)
    lines += table(
        ("node", "rms K", "peak K", "steady K"),
        [(r.node[i], f"{r.node_rms[i]:.3g}", f"{r.node_peak[i]:.3g}", f"{r.steady_K[i]:.6g}") for i in order],
        right=(1, 2, 3),
    )
    if len(order) < len(r.node):
        lines.append(f"{count(len(r.node) - len(order), 'more node')} move less: --top 0 lists them")
    lines.append(_step_line(r))
    if r.radiates:
        lines.append(
            f"linear about the steady state: no temperature changes by more than {r.largest_change:.2g} of itself, so"
            f" radiation follows within {r.nonlinear:.2g} of its change"
        )
    if r.source is None:
        lines.append(
            "too short to compare spectra with those of thermal.h5" if r.check is None else _check_line(r.check)
        )
    if r.output is not None:
        lines.append(f'{r.output}: temperatures of {count(r.columns, "node")} about the steady state; a [[series]] of'
                     ' = "nodes" with remove = "nothing" takes them')  # fmt: skip
    return lines


def _order(r: InTime, top: int | None) -> list[int]:
    """The nodes that move most, the first of all."""
    return sorted(range(len(r.node)), key=lambda i: -float(r.node_rms[i]))[:top]


def _step_line(r: InTime) -> str:
    if r.exact:
        return "steps exact, of disturbances that are straight between samples"
    worst = int(r.error_K.argmax())
    return (
        "implicit steps, of disturbances that are straight between samples: estimated error at most"
        f" {r.error_K[worst]:.2g} K ({r.node[worst]})"
    )


def _check_line(c: SpectraCheck) -> str:
    nodes, frequencies = count(c.nodes, "node"), count(len(c.frequency_hz), "frequency", "frequencies")
    return (
        f"spectra {'agree' if c.agrees else 'DO NOT AGREE'} with those of thermal.h5 ({nodes}, {frequencies} from"
        f" {c.frequency_hz[0]:.3g} to {c.frequency_hz[-1]:.3g} Hz): PSD over its expectation, mean of a node"
        f" {c.mean.min():.3f} to {c.mean.max():.3f}, by chance {c.allowed[0]:.3f} to {c.allowed[1]:.3f}; {c.inside:.1%}"
        f" of all values hold it in their 95 % interval; samples change it by at most {c.straight:.2g} at the highest"
    )


def in_time_dict(r: InTime, top: int | None) -> dict[str, Any]:
    """What a program needs."""
    order = _order(r, top)
    return {
        "file": None if r.output is None else str(r.output),
        "source": None if r.source is None else str(r.source),
        "seed": r.seed if r.source is None else None,
        "samples": r.samples,
        "step_s": r.step_s,
        "slowest_time_constant_s": r.slowest_s,
        "settled_s": r.settled_s,
        "exact": r.exact,
        "largest_relative_change": r.largest_change,
        "radiation_nonlinear": r.nonlinear,
        "disturbances": [
            {"name": name, "unit": _UNIT[kind], "rms": float(rms), "peak": float(peak), "constant": name in r.constant}
            for name, kind, rms, peak in zip(r.disturbance, r.kind, r.rms, r.peak, strict=True)
        ],
        "nodes": [
            {
                "name": r.node[i],
                "rms_K": float(r.node_rms[i]),
                "peak_K": float(r.node_peak[i]),
                "steady_K": float(r.steady_K[i]),
                "error_K": float(r.error_K[i]),
            }
            for i in order
        ],
        "check": None if r.check is None else {
            "agrees": r.check.agrees,
            "inside": r.check.inside,
            "nodes": r.check.nodes,
            "frequency_hz": r.check.frequency_hz.tolist(),
            "mean_ratio": r.check.mean.tolist(),
            "mean_ratio_allowed": list(r.check.allowed),
            "samples_change": r.check.straight,
        },
    }  # fmt: skip
