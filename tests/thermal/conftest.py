"""Where the tools of other tests are."""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).parents[1] / "borders"))
