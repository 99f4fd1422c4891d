"""All commands. Stages are imported inside them: `tedm --help` does not wait for SciPy, pyNastran or matplotlib."""

# Importing a module registers its commands, in the order in which `tedm --help` lists them.
from tedm_cli.cli import chain, areas, model, gravity, optics, adjoint, noise, dynamics, results, exports  # noqa: F401, I001
from tedm_cli.cli.app import app, command_line

__all__ = ["app", "command_line"]
