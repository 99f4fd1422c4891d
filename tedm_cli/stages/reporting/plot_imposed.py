"""plot, figure 6.2: acceleration noise of test masses with imposed positions, where it has been made."""

from __future__ import annotations

from functools import partial

from tedm_cli.figures.drawing.spec import FigureSpec
from tedm_cli.results.build_folder import Results
from tedm_cli.results.dynamics.imposed import ImposedMotion, read_imposed
from tedm_cli.stages.reporting import draw


def imposed_specs(results: Results) -> list[FigureSpec]:
    """The figure, or none."""
    if results.imposed is None or results.imposed_file is None:
        return []
    found, used = read_imposed(results.imposed), results.imposed_file
    return [
        FigureSpec(
            "figure_6_2.svg", "field", imposed_words(found), (f"{used.path.name} {used.sha256}",),
            partial(draw.imposed, found),
        )
    ]  # fmt: skip


def imposed_words(found: ImposedMotion) -> str:
    """Its caption."""
    return (
        f"Acceleration noise along x through the stiffness of self-gravity, without a loop: every test mass moves along"
        f" its x by {1e9 * found.motion[0]:.3g} nm/√Hz, independently ({found.motion_source}). Left: by all sources"
        " together, and by the other test mass alone as in figure 6.2 of Montemurro 2004; without a safety factor."
        " Right: by each source alone. Sources feel one motion and may cancel."
    )
