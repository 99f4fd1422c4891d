"""The fonts of the figures, for who sets text around them."""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl


def font_folder() -> str:
    """Folder of the TrueType fonts that ship with matplotlib, DejaVu Sans among them."""
    return str(Path(mpl.get_data_path()) / "fonts" / "ttf")
