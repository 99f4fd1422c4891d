"""The shipped cases file for projects that have no thermal network: all its cases but that of the network."""

from __future__ import annotations

import re
from pathlib import Path

CASES_TOML = Path(__file__).parents[1] / "configs" / "cases.toml"
OF_AREAS = ("1", "2", "3", "4", "4b", "5", "6", "7", "8", "9", "10", "10b")
NETWORK = "T"


def cases_of_areas() -> str:
    """The text of the file without the case of the thermal network."""
    text = CASES_TOML.read_text(encoding="utf-8")
    kept, removed = re.subn(rf'(?ms)^\[\[case\]\]\nid = "{NETWORK}"$.*?^thermal = true\n', "", text)
    assert removed == 1
    return kept
