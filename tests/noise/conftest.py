from pathlib import Path

import numpy as np
import pytest

from tedm_cli.config.cases import CasesConfig, load_cases
from tedm_cli.noise.areas import AreaTable


@pytest.fixture(scope="session")
def areas() -> AreaTable:
    """The 78 areas of the published model: 8 struts and 4 flanges outside, 26 + 26 + 14 inside (Montemurro, 3.4)."""
    names, groups, shields, sides, centroids = [], [], [], [], []
    for group, count, shield in (
        ("struts", 8, "outside"),
        ("flanges", 4, "outside"),
        ("IS1", 26, "inside"),
        ("IS2", 26, "inside"),
        ("OB", 14, "inside"),
    ):
        for i in range(count):
            names.append(f"{group.upper()}_{i + 1}")
            groups.append(group)
            shields.append(shield)
            sides.append(("+y", "-y")[i % 2] if shield == "outside" else ("+y", "-y", "mid")[i % 3])
            # Outside, neighbours in the list are mirror images but for the unevenness of a mesh.
            y = {"+y": 0.2, "-y": -0.203, "mid": 0.0}[sides[-1]]
            centroids.append(
                (
                    0.1 * (i // 2),
                    y,
                    0.05 * len(groups) if shield == "inside" else (0.3 if group == "struts" else 0.6) + 0.001 * (i % 2),
                )
            )
    return AreaTable(np.array(names), np.array(groups), np.array(shields), np.array(sides), np.array(centroids))


@pytest.fixture(scope="session")
def config() -> CasesConfig:
    """The cases file that ships."""
    return load_cases(Path(__file__).parents[2] / "configs" / "cases.toml")[1]
