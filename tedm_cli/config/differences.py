"""Requirements on the difference of two outputs: only along axes that the test masses have in common."""

from __future__ import annotations

from collections.abc import Sequence

from tedm_cli.config.model.file import ModelConfig, load_model
from tedm_cli.config.optics.layout import load_layout
from tedm_cli.config.project import Project
from tedm_cli.errors import ConfigError
from tedm_cli.gravity.operator import sensitivity_row_labels
from tedm_cli.gravity.testmass import TestMass
from tedm_cli.noise.differences import terms
from tedm_cli.noise.requirements import AppliedRequirement
from tedm_cli.optics.layout import DOF_COLUMN, OpticalLayout
from tedm_cli.parallel_axes import MassAxis, why_no_difference


def require_parallel(
    project: Project, requirements: Sequence[AppliedRequirement], model: ModelConfig | None = None
) -> None:
    """Refuse differences of test masses whose axes there are not parallel; `model` where it has been read already.

    Axes are those of the model for self-gravity, those of the layout for read-outs.

    Raises
    ------
    ConfigError : all such differences of the project's cases file.
    """
    pairs = {
        f"requirement[{number}].outputs[{index}]": (label, pair)
        for number, applied in enumerate(requirements)
        for index, label in enumerate(applied.outputs)
        if (pair := terms(label)) is not None
    }
    if not pairs:
        return
    config = model if model is not None else load_model(project.model)[1]
    axis = gravity_axes(config.test_masses())
    if project.optics is not None and any(label not in axis for _, pair in pairs.values() for label in pair):
        axis |= read_out_axes(load_layout(project.optics)[1])
    problems = []
    for place, (label, (first, second)) in pairs.items():
        if first not in axis or second not in axis or axis[first].test_mass == axis[second].test_mass:
            continue  # what there is not is told of where outputs are judged
        if fact := why_no_difference(axis[first], axis[second]):
            problems.append((place, f"{label}: {fact}"))
    if problems:
        raise ConfigError(problems, where=str(project.cases), hint="judge each test mass by itself, as single outputs")


def gravity_axes(test_masses: Sequence[TestMass]) -> dict[str, MassAxis]:
    """By label of a self-gravity output, the axis that it is along or about; basic frame."""
    of = {tm.name: tm.axes for tm in test_masses}
    axis = {}
    for label in sensitivity_row_labels(test_masses):
        name, _, letter = label.rsplit("_", 2)
        axis[label] = MassAxis(name, letter, of[name]["xyz".index(letter)])
    return axis


def read_out_axes(layout: OpticalLayout) -> dict[str, MassAxis]:
    """The same by label of a read-out; layout frame."""
    axis = {}
    for mass, axes in zip(layout.test_masses, layout.test_mass_axes, strict=True):
        for dof in layout.measured(mass):
            number = DOF_COLUMN[dof] % 3
            for name in layout.sets:
                axis[f"{name}_{mass.name}_{dof}"] = MassAxis(mass.name, "xyz"[number], axes[number])
    return axis
