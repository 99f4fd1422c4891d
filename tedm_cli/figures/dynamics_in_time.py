"""Realisations of the loop: their estimates over what the exact spectra expect."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator

from tedm_cli.figures.drawing.fit import wrapped
from tedm_cli.figures.drawing.key import key
from tedm_cli.figures.drawing.style import COLOURS, SMALL, WIDTH, frequency_axis, grid, heading, heading_lines, style
from tedm_cli.results.cases.noise import REALISATION_CONFIDENCE
from tedm_cli.results.cases.series import thinned
from tedm_cli.results.dynamics.in_time import RealisedCase
from tedm_cli.results.titles import output_title
from tedm_cli.results.wording import capital

_STRIP, _BETWEEN, _FOOT, _LEFT, _RIGHT = 0.95, 0.32, 0.55, 0.8, 0.15  # inches
_INTERVAL = "#B5B5B5"


def realisation_figure(r: RealisedCase) -> Figure:
    """A strip for each output: amplitude of the estimate over its expectation, with the interval that should hold 1."""
    with style():
        n = len(r.ratio)
        title = f"Realisation of case {r.case} in closed loop"
        more = (
            f"{r.samples:,} samples at {r.rate_hz:g} Hz, seed {r.seed}; {r.degrees_of_freedom:.3g} degrees of freedom"
        )
        entries = [
            Line2D([], [], color=COLOURS[1], linewidth=1.2, label="amplitude of the estimate over its expectation"),
            Patch(color=_INTERVAL, label=f"its {100 * REALISATION_CONFIDENCE:g} % interval"),
        ]
        legend = key(entries, WIDTH - 0.3)
        top = heading_lines(title, more)[2] + 0.3
        foot = _FOOT + legend.height
        tall = top + n * _STRIP + (n - 1) * _BETWEEN + foot
        figure = Figure(figsize=(WIDTH, tall))
        spectra = {output: thinned(ratio) for output, ratio in r.ratio.items()}
        spread = max(max(float(np.abs(s.high - 1).max()), float(np.abs(s.low - 1).max())) for s in spectra.values())
        for row, (output, s) in enumerate(spectra.items()):
            bottom = tall - top - _STRIP - row * (_STRIP + _BETWEEN)
            axes = figure.add_axes((_LEFT / WIDTH, bottom / tall, (WIDTH - _LEFT - _RIGHT) / WIDTH, _STRIP / tall))
            x, y = s.trace()
            axes.fill_between(s.frequency_hz * 1e3, s.low, s.high, color=_INTERVAL, linewidth=0)
            axes.plot(x * 1e3, y, color=COLOURS[1], linewidth=0.6)
            axes.axhline(1.0, color="black", linewidth=1.0)
            frequency_axis(axes, float(s.frequency_hz[0]), float(s.frequency_hz[-1]))
            axes.set_ylim(max(0.0, 1.0 - 1.1 * spread), 1.0 + 1.1 * spread)
            axes.yaxis.set_major_locator(MaxNLocator(3))
            axes.tick_params(labelsize=SMALL, labelbottom=row == n - 1)
            axes.set_xlabel("frequency (mHz)" if row == n - 1 else "", fontsize=SMALL, labelpad=1)
            axes.set_ylabel("estimate /\nexact (1)", fontsize=SMALL, labelpad=1)
            grid(axes)
            words = f"{capital(output_title(output))} ({output}): mean of the power {r.mean[output]:.3f}"
            figure.text(_LEFT / WIDTH, (bottom + _STRIP + 0.05) / tall, wrapped(words, WIDTH - _LEFT - _RIGHT, SMALL),
                        fontsize=SMALL, va="bottom")  # fmt: skip
        heading(figure, title, more=more)
        legend.draw(figure, 0.15, 0.08)
        return figure
