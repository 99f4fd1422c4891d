"""The evidence that decides, as the report tells it: what limits, field at rest, how sure, key figures, assumptions."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tedm_cli.gravity.requirements import DcVerdict
from tedm_cli.noise.areas import AreaTable
from tedm_cli.report.cases import what_cases_stand_for
from tedm_cli.report.decision import field_words, how_sure, limited_by
from tedm_cli.report.document import (
    Block,
    Cell,
    Facts,
    Figure,
    Link,
    Paragraph,
    Ref,
    Row,
    Section,
    Table,
    Text,
    columns,
    row,
)
from tedm_cli.report.uncertain import uncertainty_facts
from tedm_cli.report.verdicts import NOT_JUDGED, Titles, exceeding, noise_judgements, worst_first
from tedm_cli.results.cases.deciding import by_requirement
from tedm_cli.results.cases.noise import CaseNoise, temperature_words
from tedm_cli.results.dynamics.loop import ClosedLoop
from tedm_cli.results.gravity.field import FieldAtRest, not_allocated
from tedm_cli.results.model import DistortionSize, ModelSize
from tedm_cli.results.optics import OpticsResults
from tedm_cli.results.ranking import first_largest
from tedm_cli.results.titles import at_rest_title, by_subsystem, mass_title, output_title
from tedm_cli.results.wording import TO_LOOK_AT, capital, count, decimals, percent, ratio_text, sci, unit_text

SHORT_STEP = 0.8  # share of an area's step that its own elements receive at least, unless it is to be looked at
_NAMED = 12  # areas named in a line


def binding_section(cases: Sequence[CaseNoise], benches: int, figures: Sequence[Figure]) -> Section:
    """Each judged output in the case that decides it: what limits it, in words; figures of the worst."""
    rows = []
    for found in worst_first(noise_judgements(cases)):
        case, j = found.decides
        rows.append(row(capital(output_title(found.output)), _where(case, j.ratio), limited_by(case, j, benches)))
    caption = "What the noise of each judged output comes from, in the case that decides its verdict."
    table = Table(columns("Output", "Ratio", "Made of", text=(0, 1, 2)), tuple(rows), caption, tight=True)
    title = "Evidence: what the noise comes from"
    return Section("binding", title, "What limits", (table, *figures))


def _where(case: CaseNoise, ratio: float) -> str:
    return f"{ratio_text(ratio)} in case {case.id}"


def at_rest_section(dc: Sequence[DcVerdict], figures: Sequence[Figure]) -> Section:
    """The field at rest: how it stands, and the quantities that exceed their limits."""
    title = "Evidence: field at rest"
    if not dc:
        told = (f"{NOT_JUDGED} What it is, by source, is in ", Link("the annex", "field-at-rest"), ".")
        return Section("at-rest", title, "Field at rest", (Paragraph(told), *figures))
    blocks: list[Block] = [
        Paragraph((f"The field at rest {field_words(dc)} All quantities: ", Ref("at rest"), ".")),
        *(Paragraph(f"Not judged: {clause}.") for clause in not_allocated(dc)),
        *figures,
    ]
    if outside := sorted(exceeding(dc), key=lambda v: -v.ratio):
        rows = tuple(
            row(
                capital(at_rest_title(v.quantity, v.place)),
                by_subsystem(v.subsystem),
                Cell(ratio_text(v.ratio), "violated"),
                sci(v.value),
                sci(v.upper if v.value > 0.0 else v.lower),
                unit_text(v.unit),
            )
            for v in outside
        )
        head = columns("Quantity", "By", "Ratio\n(1)", "Value", "Limit", "Unit", text=(0, 1, 5))
        blocks.append(Table(head, rows, "Every quantity of the field at rest that exceeds its limit.", tight=True))
    return Section("at-rest", title, "Field at rest", tuple(blocks))


def how_sure_section(cases: Sequence[CaseNoise], figures: Sequence[Figure]) -> Section:
    """Whether other temperature filters, correlations or safety factors would turn a verdict."""
    rows = []
    for found in worst_first(noise_judgements(cases)):
        case, j = found.decides
        rows.append(row(capital(output_title(found.output)), _where(case, j.ratio), how_sure(case, j)))
    text = (
        "Verdicts depend on assumptions: temperature filter, correlation of the areas, safety factor. Every ratio under"
        " other ones is in ",
        Ref("sure"),
        ".",
    )
    caption = "Whether other assumptions would change a verdict, one changed at a time."
    table = Table(columns("Output", "Ratio", "With others", text=(0, 1, 2)), tuple(rows), caption, tight=True)
    return Section("sure", "Evidence: how sure the verdicts are", "How sure", (Paragraph(text), table, *figures))


def key_figures_section(
    model: ModelSize,
    distortion: DistortionSize,
    field: FieldAtRest | None,
    optics: OpticsResults | None,
    areas: AreaTable,
    loop: ClosedLoop | None,
) -> Section:
    """The figures by which one model is told from another."""
    rows: list[Row] = [
        row("Model", f"{model.grids:,} grids, {len(model.card):,} elements, {len(areas)} thermal areas"),
        row("Mass", f"{model.mass_kg:.6g} kg"),
        row("Centre of gravity", f"{decimals(model.centre_of_gravity_m.tolist(), 1e3, 3)} mm, Nastran basic frame"),
        row("Symmetry plane of sides and mirror pairs", model.symmetry_plane),
        *(
            row(
                f"Largest translation of a grid{' by a gradient' * (unit != 'K')}",
                f"{sci(largest, 3)} m per {'kelvin' if unit == 'K' else unit} of {name}",
            )
            for unit, largest, name in distortion.most(distortion.largest)
        ),
        *_mean_steps(model),
    ]
    if distortion.superposition_translation is not None:
        residual = sci(distortion.superposition_translation, 2)
        rows.append(
            row(
                f"Sum of all {'mean temperatures' if areas.gradient.any() else 'areas'} against the uniform load",
                f"differs by {residual} of the largest translation",
            )
        )
    if field is not None:
        for name, a in zip(field.test_mass, field.acceleration.sum(axis=1), strict=True):
            parts = ", ".join(sci(float(v), 3) for v in a)
            rows.append(
                row(
                    f"Acceleration at rest of {mass_title(name)}",
                    f"({parts}) m/s² along x, y, z, the axes of the test mass",
                )
            )
    if optics is not None:
        rows += _read_outs(optics, areas)
    if loop is not None:
        phases = [x for x in loop.stability.loops if np.isfinite(x.phase_deg)]
        least = min(phases, key=lambda x: x.phase_deg) if phases else None
        words = f"; smallest phase margin {least.phase_deg:.1f}° ({least.name})" if least else ""
        rows.append(row("Drag-free loop", f"{count(len(loop.stability.loops), 'loop')}, stable{words}"))
    head = columns("Figure", "Value", text=(0, 1))
    return Section(
        "key", "Key figures", "Key figures", (Table(head, tuple(rows), "Key figures of the model.", tight=True),)
    )


def _mean_steps(model: ModelSize) -> list[Row]:
    """The share of its step that an area's own elements receive, where the file says it; what is short is named."""
    if model.mean_step is None:
        return []
    share, means = model.mean_step, np.flatnonzero(~model.areas.gradient)
    short = [i for i in means[np.argsort(share[means], kind="stable")].tolist() if share[i] < SHORT_STEP]
    title = "Step that the elements of an area receive"
    if not short:
        return [row(title, f"at least {percent(float(share[means].min()))} of 1 K in every area")]
    listed = ", ".join(f"{model.areas.name[i]} {percent(float(share[i]))}" for i in short[:_NAMED])
    more = f" and {len(short) - _NAMED} more" if len(short) > _NAMED else ""
    said = (
        f"below {percent(SHORT_STEP)} in {count(len(short), 'area')}: {listed}{more}; their own distortion is"
        " computed too small by as much, because grids on their borders are warmed with their neighbours"
    )
    return [row(title, Cell(said, "open"))]


def _read_outs(optics: OpticsResults, areas: AreaTable) -> list[Row]:
    """The largest read-outs of the first set, and how well all sets are determined."""
    r, rows = optics.read_outs, list[Row]()
    first = r.sets[0]
    means, names = ~areas.gradient, areas.name
    for label, unit, values in zip(r.label, r.unit, r.N[first], strict=True):
        if unit != "m":
            continue
        title = output_title(f"{first}_{label}")
        worst = first_largest(np.flatnonzero(means).tolist(), np.abs(values[means]).tolist())
        rows.append(
            row(
                f"Largest {title}",
                f"{sci(float(values[worst]), 3)} {unit} per kelvin of {names[worst]};"
                f" {sci(float(values[means].sum()), 3)} {unit} per kelvin of all"
                f" {'mean temperatures' if areas.gradient.any() else 'areas'} together",
            )
        )
        if areas.gradient.any():
            worst = first_largest(np.flatnonzero(areas.gradient).tolist(), np.abs(values[areas.gradient]).tolist())
            rows.append(
                row(
                    f"Largest {title} by a gradient", f"{sci(float(values[worst]), 3)} {unit} per K/m of {names[worst]}"
                )
            )
    conditions = ", ".join(f"{sci(c, 3)} (set {name})" for name, c in optics.quality.condition.items())
    return [*rows, row("Condition number of the read-out", f"{conditions}; in metres and radians")]


def assumptions_section(
    cases: Sequence[CaseNoise],
    field: FieldAtRest | None,
    layout_notes: Sequence[str],
    loop: ClosedLoop | None,
    titles: Titles,
) -> Section:
    """What every verdict takes for granted: temperatures, safety factor, cases, requirements, masses, an odd layout."""
    first = cases[0]
    factor = f"{first.safety_factor:g}, on noise amplitudes wherever they are compared to a requirement"
    facts: list[tuple[str, Text]] = [
        ("Temperature noise", temperature_words({c.id: c.temperature for c in cases})),
        ("Safety factor", factor),
    ]
    if first.filter_order.size:
        orders = ", ".join(f"{v:g}" for v in first.filter_order)
        corners = ", ".join(f"{v * 1e3:g}" for v in first.filter_corner_hz)
        facts.append(
            (
                "Temperature filter",
                "order and corner of the low-pass temperature filter are assumed, and verdicts depend on them; tried as"
                f" well: every order of {orders} with every corner of {corners} mHz, levels held at the reference"
                " frequency",
            )
        )
    facts += uncertainty_facts(cases)
    if field is not None:
        how = {"quadrature": "spread over its elements", "lumped": "lumped at its grids"}.get(
            field.mass_model, field.mass_model
        )
        facts.append(("Mass of the structure", f"{how} ({field.mass_model})"))
    if loop is not None:
        facts.append(("Drag-free loop", f"{loop.stability.origin}; hears set {loop.cases[0].read_out_set}"))
    facts += [(TO_LOOK_AT, note) for note in layout_notes]
    limits = {limit.name: limit for limit, _ in by_requirement(cases)}
    for case in loop.cases if loop is not None else ():
        limits |= {limit.name: limit for limit in case.limits}
    rows = tuple(
        row(
            Cell(titles(limit.name), label=limit.name),
            f"{limit.band_hz[0] * 1e3:g} to {limit.band_hz[1] * 1e3:g} mHz",
            f"{unit_text(limit.unit)}/√Hz",
            limit.source,
        )
        for limit in limits.values()
    )
    head = columns("Requirement", "Band", "Unit", "Source", text=(0, 1, 2, 3))
    blocks: list[Block] = [Facts(tuple(facts)), what_cases_stand_for(cases)]
    if rows:
        blocks.append(Table(head, rows, "The requirements, and where they are from.", tight=True))
    return Section("assumptions", "Assumptions", "Assumptions", tuple(blocks))
