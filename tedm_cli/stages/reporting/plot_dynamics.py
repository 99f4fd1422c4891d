"""plot, the drag-free loop: its margins, and of every judged output the budget in the likely case that is worst."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path

from tedm_cli.dynamics.judging import THERMAL
from tedm_cli.dynamics.signals import DELTA_G
from tedm_cli.figures.drawing.spec import FigureSpec
from tedm_cli.files.build_folder import case_file_name
from tedm_cli.results.build_folder import Results
from tedm_cli.results.cases.noise import titled
from tedm_cli.results.dynamics.loop import FAMILIES, LoopOutput, LoopStability, SimulatedCase, read_closed_loop
from tedm_cli.results.titles import output_title
from tedm_cli.results.wording import and_text, ratio_text
from tedm_cli.stages.reporting import draw

SECTION = "closed loop"


def dynamics_specs(results: Results) -> list[FigureSpec]:
    """Figures of the closed loop, in the order of the report; none where it has not been simulated."""
    found = read_closed_loop(results.dynamics, results.simulations)
    if found is None or results.dynamics_file is None:
        return []
    titles = results.requirement_titles
    found = replace(found, cases=tuple(replace(c, limits=titled(c.limits, titles)) for c in found.cases))
    of_case = {
        case.id: (f"{used.path.name} {used.sha256}",)
        for case, used in zip(found.cases, results.simulation_files, strict=True)
    }
    loop = (f"{results.dynamics_file.path.name} {results.dynamics_file.sha256}",)
    specs = [
        FigureSpec(
            "loop_margins.svg", SECTION, loop_words(found.stability), loop, partial(draw.loop_margins, found.stability)
        )
    ]
    worst, told = found.worst_likely(), found.told_first()
    for output, (case, j) in worst.items():
        name = f"budget_{output}_{Path(case_file_name(case.id)).stem}.svg"
        drawn, decides = partial(draw.budget, case, j), told is not None and told[1].output == output
        specs.append(FigureSpec(name, SECTION, budget_words(case, j), of_case[case.id], drawn, decides))
    delta_g = next((worst[output] for output in DELTA_G if output in worst), None)
    if delta_g is not None and delta_g[1].feels_temperatures:
        case, j = delta_g
        name = f"closed_loop_thermal_{Path(case_file_name(case.id)).stem}.svg"
        specs.append(
            FigureSpec(
                name,
                SECTION,
                _thermal_words(case, j),
                of_case[case.id],
                partial(draw.closed_loop_thermal, case, j),
                decides=True,
            )
        )
    return specs


def loop_words(stability: LoopStability) -> str:
    """Caption of the margins."""
    families = stability.families()
    which = f" ({and_text(list(families))})" if set(families) <= set(FAMILIES) else ""
    crossed = any(x.crosses for x in stability.loops)
    return (
        f"The open loops L of the controller{which}, each broken while the others are closed. Left: gain and phase"
        + ", with a dot at the highest crossover of each" * crossed
        + ". Right: L near −1 (cross); no loop beside it comes nearer than the dotted circle"
        + ". Legends: phase margin." * crossed
        + "." * (not crossed)
    )


def budget_words(case: SimulatedCase, j: LoopOutput) -> str:
    """Caption of the budget of an output."""
    limits = case.limits_of(j.output)
    groups = case.seen_groups(j)
    temperatures = ", the temperatures among them," if THERMAL in groups else ""
    black = "requirement with its band" if len(limits) == 1 else "requirements with their bands"
    return (
        f"What the noise of the {output_title(j.output)} in closed loop is made of in case {case.id}: amplitude"
        " spectral density times"
        f" the safety factor {case.safety_factor:g}, in total and by group of sources{temperatures} and the {black}."
    )


def _thermal_words(case: SimulatedCase, j: LoopOutput) -> str:
    several = len(case.limits_of(j.output)) > 1
    return (
        f"The part of the temperatures in the {output_title(j.output)}, closed loop, case {case.id}, times the safety"
        " factor"
        f" {case.safety_factor:g}: gravity and read-out as they add with their phases, as they would add without, and"
        f" gravity alone; in black the requirement{'s' * several}. Without phases the power at the frequency that binds"
        f" would be {ratio_text(j.incoherent)} times as large."
    )
