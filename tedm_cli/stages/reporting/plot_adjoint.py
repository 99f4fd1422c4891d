"""plot, the adjoint: where on the model a kelvin acts on each judged output."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache, partial
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from tedm_cli.adjoint.places import density_bound
from tedm_cli.contracts import SENSITIVITY, UNIT_LOADS
from tedm_cli.figures.drawing.spec import FigureSpec
from tedm_cli.files.build_folder import UNIT_LOADS_FILE, require_input
from tedm_cli.files.provenance import input_files
from tedm_cli.files.store import open_checked
from tedm_cli.report.where import binding_output
from tedm_cli.results.adjoint.file import field_ratio, read_field_error
from tedm_cli.results.adjoint.map import has_map, read_map, read_mapped_model
from tedm_cli.results.build_folder import Results
from tedm_cli.results.cases.deciding import without_repeats
from tedm_cli.results.cases.noise import CaseNoise
from tedm_cli.results.titles import output_title
from tedm_cli.results.wording import unit_text
from tedm_cli.stages.reporting import draw

if TYPE_CHECKING:
    from tedm_cli.figures.model.adjoint_map import MapViews

SECTION = "where"


def adjoint_specs(
    results: Results, cases: Sequence[CaseNoise], views: Callable[[], MapViews] | None
) -> list[FigureSpec]:
    """A figure of each judged output that the adjoint has; of outputs that say the same, of the first."""
    if results.adjoint is None or results.adjoint_file is None or views is None:
        return []
    adjoint, source = results.adjoint, results.adjoint_file
    judged = dict.fromkeys(j.output for j in without_repeats(cases)[0].judged)
    first = binding_output(cases)
    specs = []
    for names in judged:
        label, title = names.split(", ")[0], output_title(names)
        if not has_map(adjoint, label):
            continue
        found = read_map(adjoint, label)
        unit = f"sensitivity per volume ({unit_text(found.unit)} per m³)"
        bound = density_bound(found.whole, found.volume)
        specs.append(
            FigureSpec(
                f"adjoint_{label}.svg",
                SECTION,
                f"Where a kelvin acts on the {title}: {unit}, of every element. Its integral over the model is what"
                " 1 K everywhere does; places of opposite colour cancel when both are warm.",
                (f"{source.path.name} {source.sha256}",),
                partial(draw.adjoint_map, views, found, bound, f"Where a kelvin acts: {title}", unit),
                decides=label == first,
            )
        )
    told = {label: field_ratio(adjoint, label) for label in (names.split(", ")[0] for names in judged)}
    ratios = {label: of[1] for label, of in told.items() if of is not None}
    lengths = read_field_error(adjoint)
    if ratios and lengths is not None:
        specs.append(
            FigureSpec(
                "areas_against_a_field.svg",
                SECTION,
                "How much areas of one temperature tell of even temperature fields, over their correlation length: root"
                " mean square of each judged output by the means over the areas, over that of the field. Below 1: what"
                " differs within the areas does the rest.",
                (f"{source.path.name} {source.sha256}",),
                partial(draw.field_ratio, 1e3 * lengths.length_m, ratios, "Thermal areas against a temperature field"),
            )
        )
    return specs


def model_views(results: Results) -> Callable[[], MapViews] | None:
    """The views of the model that all maps share, found when the first of these is drawn; None without an adjoint."""
    if results.adjoint is None or results.gravity is None:
        return None
    adjoint, gravity = results.adjoint, results.gravity.reader

    @cache
    def found() -> MapViews:
        from tedm_cli.figures.model.adjoint_map import MapViews
        from tedm_cli.figures.model.views import Mesh

        path = adjoint.path.with_name(UNIT_LOADS_FILE)
        require_input(adjoint, input_files([path])[0])
        with open_checked(path, UNIT_LOADS) as unit:
            model = read_mapped_model(adjoint, unit)
        signs = np.array(list(product((-0.5, 0.5), repeat=3)))[:, ::-1]
        names = (SENSITIVITY.TEST_MASS_BOX_CENTRE, SENSITIVITY.TEST_MASS_SIDE, SENSITIVITY.TEST_MASS_AXES)
        boxes = zip(*map(gravity.array, names), strict=True)
        mesh = Mesh(
            position=model.position,
            card=model.card,
            node_offset=model.offset,
            node_index=model.node,
            boxes=[centre + (signs * side) @ axes for centre, side, axes in boxes],
            centre=gravity.array(SENSITIVITY.TEST_MASS_POSITION)[0],
        )
        return MapViews(mesh)

    return found
