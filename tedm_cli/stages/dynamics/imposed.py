"""simulate --figure-6.2: acceleration noise of test masses with imposed positions, through stiffness of gravity."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tedm_cli.config.model.file import load_model
from tedm_cli.config.project import Project
from tedm_cli.contracts import IMPOSED as KIND
from tedm_cli.contracts import SENSITIVITY as SENSITIVITY_KIND
from tedm_cli.dynamics.imposed import MOTIONS, MovedTestMass, of_model, published
from tedm_cli.dynamics.signals import TEST_MASSES
from tedm_cli.errors import ConfigError
from tedm_cli.files.build_folder import IMPOSED_FILE, SENSITIVITY_FILE, provenance, require_configuration
from tedm_cli.files.store import Reader, create, open_checked
from tedm_cli.gravity.field import SOURCES
from tedm_cli.noise.requirement_presets import PRESETS
from tedm_cli.noise.requirements import frequency_grid, judge
from tedm_cli.results.dynamics.imposed import ImposedMotion, read_imposed
from tedm_cli.stages.common import out_path

MOTION, LIMIT = PRESETS["lpf_jitter"], PRESETS["lpf_selfgravity_ltp"]
_POINTS = 61


def imposed_motion(project: Project, output: Path | None) -> tuple[Path, ImposedMotion]:
    """Compute and write the noise of the published tables and of the project's own model; the file and what it says.

    Raises
    ------
    InputError : sensitivity.h5 is missing or stale.
    ConfigError : not two test masses.
    """
    load_model(project.model)[1].required_test_masses(project.model)
    path = project.build_dir / SENSITIVITY_FILE
    with open_checked(path, SENSITIVITY_KIND) as sensitivity:
        require_configuration(sensitivity, project.model)
        rows = [published(), *_own(sensitivity, project)]
    frequency = frequency_grid(*MOTION.band_hz, _POINTS, [LIMIT.grid_hz])
    motion = MOTION.amplitude(frequency)
    stiffness = np.zeros((len(rows), len(SOURCES), len(MOTIONS)))
    alone, share = np.zeros(stiffness.shape[:2]), np.zeros(stiffness.shape[:2])
    for n, row in enumerate(rows):
        at = [SOURCES.index(name) for name in row.sources]
        stiffness[n, at], alone[n, at], share[n, at] = row.stiffness, row.gain_alone, row.share
    asd = np.array([row.gain for row in rows])[:, None] * motion
    verdicts = [
        judge(one, frequency, LIMIT, 1.0, kind=LIMIT.kind, output=r.name) for one, r in zip(asd, rows, strict=True)
    ]
    out = out_path(project, IMPOSED_FILE, output)
    with create(out, KIND, provenance([], [path])) as writer:
        writer.write(KIND.FREQUENCY, frequency)
        writer.write(KIND.MOTION_SOURCE, MOTION.source)
        writer.write(KIND.MOTION_AMPLITUDE, motion)
        writer.write(KIND.MOTION_NAME, list(MOTIONS))
        writer.write(KIND.REQUIREMENT_NAME, LIMIT.name)
        writer.write(KIND.REQUIREMENT_SOURCE, LIMIT.source)
        writer.write(KIND.REQUIREMENT_LEVEL, LIMIT.amplitude(np.zeros(1))[0])
        writer.write(KIND.REQUIREMENT_AMPLITUDE, LIMIT.amplitude(frequency))
        writer.write(KIND.ROW_MODEL, [row.model for row in rows])
        writer.write(KIND.ROW_TEST_MASS, [row.name for row in rows])
        writer.write(KIND.SOURCE_NAME, list(SOURCES))
        writer.write(KIND.STIFFNESS, stiffness)
        writer.write(KIND.ASD, asd)
        writer.write(KIND.ASD_ALONE, alone[:, :, None] * motion)
        writer.write(KIND.SHARE, share)
        writer.write(KIND.RATIO, [v.ratio for v in verdicts])
        writer.write(KIND.BINDING_FREQUENCY, [v.binding_hz for v in verdicts])
    with open_checked(out, KIND) as done:
        return out, read_imposed(done)


def _own(sensitivity: Reader, project: Project) -> list[MovedTestMass]:
    """The project's two test masses, each along its own x."""
    names = sensitivity.strings(SENSITIVITY_KIND.TEST_MASS_NAME)
    if len(names) != len(TEST_MASSES):
        fact = f"figure 6.2 is of two test masses; this project has {len(names)}"
        raise ConfigError([("test_mass", fact)], where=str(project.model))
    linearised = sensitivity.array(SENSITIVITY_KIND.STIFFNESS_LINEARISED)
    mutual = np.array([linearised[0, 6], linearised[6, 0]])
    gamma_xx = sensitivity.array(SENSITIVITY_KIND.STIFFNESS_GAMMA_LIN)[:, :, 0, 0]
    return of_model(names, sensitivity.strings(SENSITIVITY_KIND.SOURCE_NAME), gamma_xx, mutual)
