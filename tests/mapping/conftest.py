"""Meshes of the tests of the embedded solver, plates on struts, and the command line."""

import sys
from pathlib import Path

sys.path += [str(Path(__file__).parents[1] / room) for room in ("fem", "borders", "areas")]
