"""All commands. Stages are imported inside them: `tedm --help` does not wait for SciPy, pyNastran or matplotlib."""

# Importing a module registers its commands; `headings` has their order.
from tedm_cli.cli import (  # noqa: F401
    adjoint,
    areas,
    balance,
    chain,
    dynamics,
    explain,
    exports,
    gravity,
    loads,
    model,
    noise,
    optics,
    results,
    thermal,
    trade,
)
from tedm_cli.cli.app import app, command_line

__all__ = ["app", "command_line"]
