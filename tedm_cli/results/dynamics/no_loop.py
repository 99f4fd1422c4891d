"""Whether a project can have a drag-free loop, and why not: what Make and the report have to know of it."""

from __future__ import annotations

import numpy as np

from tedm_cli.config.model.file import ModelConfig
from tedm_cli.config.project import Project
from tedm_cli.dynamics.bodies import angle_words, x_axes_are_parallel
from tedm_cli.dynamics.signals import TEST_MASSES
from tedm_cli.results.wording import count


def why_no_loop(project: Project, model: ModelConfig) -> str:
    """In a sentence why no drag-free loop is closed; empty where it can be.

    Test masses whose x axes are not parallel are no obstacle where the project names a file of dynamics: what it says
    is taken at its word, and refused where it needs parallel axes.
    """
    masses = len(model.test_mass)
    if masses != len(TEST_MASSES):
        with_them = f"with {count(masses, 'test mass', 'test masses')}" if masses else "without them"
        return f"The drag-free loop needs two test masses; {with_them} there is no loop."
    if project.optics is None:
        return "The drag-free loop needs the read-outs of both test masses; without optics there is no loop."
    axes = np.array([t.axes for t in model.test_masses()])
    if project.dynamics is None and not x_axes_are_parallel(axes):
        first, second = (t.name for t in model.test_mass)
        return (
            "There is no drag-free loop: the default controller and Δg need test masses whose x axes are parallel,"
            f" and those of {first} and {second} are {angle_words(axes)} apart; your own controller, in a file of"
            " dynamics, would be used."
        )
    return ""
