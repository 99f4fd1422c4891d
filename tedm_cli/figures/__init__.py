"""Arrays to matplotlib figures; the only room that imports matplotlib, and none of it keeps pyplot's state."""

import os

# Figures are files, whatever the user's own programs draw on: matplotlib fails at a backend that is not installed here,
# which the terminals of notebooks name.
os.environ["MPLBACKEND"] = "agg"
