"""audit-mesh: which elements are too large for their distance from a test mass, and what that costs."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.config.model.at_rest import rest_of
from tedm_cli.config.model.file import load_model
from tedm_cli.config.project import Project
from tedm_cli.contracts import DISTORTION, UNIT_LOADS
from tedm_cli.files.blocks import Blocks, SomeNodes
from tedm_cli.files.build_folder import DISTORTION_FILE, UNIT_LOADS_FILE, require_input
from tedm_cli.files.provenance import input_files
from tedm_cli.files.seal import sha256_of
from tedm_cli.files.store import Reader, open_checked, replacing
from tedm_cli.gravity.audit import MODELS, MeshAudit, Motion, audit_mesh
from tedm_cli.gravity.masses import MassDistribution
from tedm_cli.gravity.requirements import narrowest
from tedm_cli.gravity.testmass import TestMass
from tedm_cli.progress import Step, counter
from tedm_cli.results.areas import read_areas
from tedm_cli.results.unit_loads import mass_of
from tedm_cli.stages.common import check_test_masses
from tedm_cli.tables.csv_table import csv_line


@dataclass(frozen=True)
class AuditSummary:
    """The audit, the property of each element, and whether it used displacements.

    mass_model : the one of `MODELS` that build-sensitivity takes.
    """

    audit: MeshAudit
    property_id: IntArray
    test_masses: list[TestMass]
    tolerance: float
    per_kelvin: bool
    mass_model: str

    def worst(self, most: int | None) -> IntArray:
        """Elements with the largest lumped error against the allowance, worst first."""
        return np.argsort(-self.audit.score[0], kind="stable")[:most]

    def by_property(self) -> list[tuple[int, int, FloatArray]]:
        """(property, its elements, [2] sum of their scores), worst lumped sum first."""
        ids, index, counts = np.unique(self.property_id, return_inverse=True, return_counts=True)
        sums = np.array([np.bincount(index.reshape(-1), row, len(ids)) for row in self.audit.score])
        return [(int(ids[i]), int(counts[i]), sums[:, i]) for i in np.argsort(-sums[0], kind="stable")]

    def binding(self, element: int) -> str:
        """The quantity in which an element's lumped error is largest against its allowance."""
        a = self.audit
        allowance = np.where(a.allowance > 0.0, a.allowance, np.inf)
        return a.label[int((np.abs(a.error[0, :, element]) / allowance).argmax())]

    def largest(self, model: str) -> tuple[str, float]:
        """The quantity whose sum is furthest from what is allowed by a mass model, and its error over that."""
        a = self.audit
        ratio = np.abs(a.total[MODELS.index(model)]) / np.where(a.allowance > 0.0, a.allowance, np.inf)
        q = int(ratio.argmax())
        return a.label[q], float(ratio[q])

    @property
    def passed(self) -> bool:
        """Whether the error that the mass model in use leaves in every sum is within what is allowed."""
        return self.largest(self.mass_model)[1] <= 1.0

    def as_dict(self, most: int | None) -> dict[str, Any]:
        """What a program needs."""
        a = self.audit
        quantities = [
            {
                "quantity": label,
                "unit": unit,
                "value": float(a.value[q]),
                "requirement": None if np.isnan(a.requirement[q]) else float(a.requirement[q]),
                "allowance": float(a.allowance[q]),
                **{
                    model: {
                        "error_of_sum": float(a.total[m, q]),
                        "sum_of_errors": float(np.abs(a.error[m, q]).sum()),
                        "root_sum_square": float(np.linalg.norm(a.error[m, q])),
                    }
                    for m, model in enumerate(MODELS)
                },
            }
            for q, (label, unit) in enumerate(zip(a.label, a.unit, strict=True))
        ]
        elements = [
            {
                "element": int(a.element_id[e]),
                "card": a.card[e],
                "property": int(self.property_id[e]),
                "size_m": float(a.size[e]),
                "gap_m": {tm.name: float(a.gap[t, e]) for t, tm in enumerate(self.test_masses)},
                "score": {model: float(a.score[m, e]) for m, model in enumerate(MODELS)},
                "quantity": self.binding(int(e)),
            }
            for e in self.worst(most)
        ]
        properties = [
            {"property": p, "elements": n, "score": dict(zip(MODELS, map(float, s), strict=True))}
            for p, n, s in self.by_property()
        ]
        worst = {model: dict(zip(("quantity", "ratio"), self.largest(model), strict=True)) for model in MODELS}
        return {
            "mass_model": self.mass_model,
            "passed": self.passed,
            "largest": worst,
            "quadrature_tolerance": self.tolerance,
            "sensitivity_per_kelvin": self.per_kelvin,
            "quantities": quantities,
            "elements": elements,
            "properties": properties,
        }


def audit(project: Project, output: Path | None, figure: Path | None, step: Step) -> AuditSummary:
    """Audit the mesh in unit_loads.h5, with the displacements of distortion.h5 where that file is there.

    `output` gets one row per element (CSV), `figure` the elements' sizes against their gaps (SVG).
    """
    _, config = load_model(project.model)
    source, moves = project.build_dir / UNIT_LOADS_FILE, project.build_dir / DISTORTION_FILE
    test_masses, tolerance = config.required_test_masses(project.model), config.gravity.quadrature_tolerance
    g, subsystems = config.gravity.gravitational_constant_m3_kg_s2, config.gravity.subsystems
    at_rest = config.limits_at_rest()
    limits = [narrowest(at_rest, tm.name, subsystems, rest_of(subsystems)) for tm in test_masses]
    with open_checked(source, UNIT_LOADS) as unit:
        check_test_masses(test_masses, unit.array(UNIT_LOADS.GRID_POSITION), where=str(project.model))
        masses = mass_of(unit)
        elements = sum(len(block.id) for block in masses.elements)
        advance = counter(step, len(test_masses) * elements, "auditing elements")
        means = np.flatnonzero(~read_areas(unit).gradient)
        ids, properties = unit.array(UNIT_LOADS.ELEMENT_ID), unit.array(UNIT_LOADS.ELEMENT_PROPERTY_ID)
    if moves.exists():
        with open_checked(moves, DISTORTION) as distortion:
            require_input(distortion, input_files([source])[0])
            motion = element_motion(distortion, masses, means)
            found = audit_mesh(masses, test_masses, motion, tolerance=tolerance, limits=limits, G=g, advance=advance)
    else:
        found = audit_mesh(masses, test_masses, None, tolerance=tolerance, limits=limits, G=g, advance=advance)
    done = AuditSummary(
        found,
        properties[np.searchsorted(ids, found.element_id)],
        test_masses,
        tolerance,
        moves.exists(),
        config.gravity.mass_model,
    )
    if output is not None:
        _write_csv(done, output)
    if figure is not None:
        _draw(done, figure, source)
    return done


def _draw(done: AuditSummary, path: Path, source: Path) -> None:
    from tedm_cli.figures.model.audit import audit_figure

    a = done.audit
    scores = dict(zip(MODELS, a.score, strict=True))
    data = audit_figure(a.size, a.gap.min(axis=0), scores, "Mesh audit", [f"{source.name} {sha256_of(source)}"])
    with replacing(path) as temporary:
        temporary.write_bytes(data)


def element_motion(distortion: Reader, masses: MassDistribution, areas: IntArray) -> Motion:
    """Displacements by these areas, read for a few elements at a time.

    The last ones are kept, since they are asked for again. All areas are of one unit, kelvin: norms are over them.
    """
    d, rotation = distortion.dataset(DISTORTION.D_TRANSLATION), distortion.dataset(DISTORTION.D_ROTATION)
    kept: list[tuple[IntArray, FloatArray, FloatArray]] = []

    def motion(nodes: IntArray, lever: FloatArray) -> FloatArray:
        if kept and np.array_equal(kept[0][0], nodes) and np.array_equal(kept[0][1], lever):
            return kept[0][2]
        kept.clear()
        move = _at(d, areas, nodes)
        on = np.any(lever != 0.0, axis=-1)
        if on.any():
            turn = _at(rotation, areas, np.searchsorted(masses.lever_node, nodes[on]))
            move[:, on] += np.cross(turn, lever[on])
        kept.append((nodes, lever, move))
        return move

    return motion


def _at(dataset: Blocks, areas: IntArray, rows: IntArray) -> FloatArray:
    """Some rows of a dataset [k,N,3], area by area: [areas, *rows, 3]."""
    wanted, place = np.unique(rows, return_inverse=True)
    some = SomeNodes(wanted)
    return np.stack([some.read(dataset, int(area))[place.reshape(rows.shape)] for area in areas])


def _write_csv(done: AuditSummary, path: Path) -> None:
    """One row per element, worst first; errors of both mass models in every quantity."""
    a = done.audit
    head = ["element", "card", "property", "size_m", *(f"gap_{tm.name}_m" for tm in done.test_masses)]
    head += [f"score_{model}" for model in MODELS]
    head += [f"{model}_{label} ({unit})" for model in MODELS for label, unit in zip(a.label, a.unit, strict=True)]
    with replacing(path) as temporary, open(temporary, "w", newline="", encoding="utf-8") as stream:
        stream.write(csv_line(head))
        for e in done.worst(len(a.element_id)):
            place = [a.element_id[e], a.card[e], done.property_id[e], f"{a.size[e]:.6g}"]
            numbers = [*a.gap[:, e], *a.score[:, e], *a.error[:, :, e].ravel()]
            stream.write(csv_line([*place, *(f"{v:.6g}" for v in numbers)]))
