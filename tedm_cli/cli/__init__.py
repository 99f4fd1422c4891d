"""The command line: load the configuration, call one stage, say what came out. All physics is in the configuration.

Stages are imported inside the commands, so that `tedm --help` does not wait for SciPy, pyNastran or matplotlib.
"""

# Importing a module registers its commands, in the order in which `tedm --help` lists them.
from tedm_cli.cli import areas, model, gravity, optics, noise, dynamics, results, exports  # noqa: F401, I001
from tedm_cli.cli.app import app
from tedm_cli.cli.main import main

__all__ = ["app", "main"]
