from __future__ import annotations

from pathlib import Path

import pytest

from tedm_cli.arrays import FloatArray
from tedm_cli.config.optics.layout import load_layout
from tedm_cli.optics.layout import OpticalLayout
from tedm_cli.optics.sensitivity import optical_sensitivity


@pytest.fixture(scope="session")
def layout_file() -> Path:
    return Path(__file__).parents[2] / "configs" / "optics.toml"


@pytest.fixture(scope="session")
def layout(layout_file: Path) -> OpticalLayout:
    return load_layout(layout_file)[1]


@pytest.fixture(scope="session")
def S_BW(layout: OpticalLayout) -> FloatArray:
    return optical_sensitivity(layout)
