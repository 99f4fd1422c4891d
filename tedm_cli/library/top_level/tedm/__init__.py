"""Thermo-elastic distortion modelling for drag-free satellites, from Python: `import tedm`.

    project = tedm.load_project()  # of this folder, or of the nearest above
    case = project.run_case(3)
    case.psd.sel(output="TM1_a_x")

Results are xarray Datasets with named dimensions, in SI. The guide is "Python library" in the documentation.
"""

from tedm_cli import __version__
from tedm_cli.errors import ConfigError, InputError, PhysicsError, UsageError
from tedm_cli.errors import TedmError as Error
from tedm_cli.gravity.testmass import TestMass
from tedm_cli.library.build import Build, open_build
from tedm_cli.library.gravity import cuboid_field, self_gravity
from tedm_cli.library.optics import trace
from tedm_cli.library.project import Project, load_project, run_case
from tedm_cli.library.tables import table

__all__ = [
    "Build",
    "ConfigError",
    "Error",
    "InputError",
    "PhysicsError",
    "Project",
    "TestMass",
    "UsageError",
    "__version__",
    "cuboid_field",
    "load_project",
    "open_build",
    "run_case",
    "self_gravity",
    "table",
    "trace",
]
