"""pyNastran is loaded without what no reading needs, and whoever needs that has it."""

from __future__ import annotations

import subprocess
import sys

CODE = """
import sys
from tedm_cli.nastran.library import without_integration
with without_integration():
    import pyNastran.bdf.bdf
    import pyNastran.op2.op2
    from pyNastran.utils import mathematics
assert not [m for m in sys.modules if m.startswith(("scipy.integrate", "scipy.optimize"))], "loaded in vain"
value, _ = mathematics.quad(lambda x: 3.0 * x * x, 0.0, 2.0)
assert abs(value - 8.0) < 1e-12, value
from scipy.integrate import solve_ivp  # the whole of it, not the stand-in
with without_integration():
    assert sys.modules["scipy.integrate"].solve_ivp is solve_ivp
"""


def test_integration_is_loaded_when_it_is_called() -> None:
    done = subprocess.run([sys.executable, "-c", CODE], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
