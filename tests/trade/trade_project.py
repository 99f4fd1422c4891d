"""Two bricks with one test mass as variants of a design: a chain of five quick steps each."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path

from border_tools import Outcome, tedm, tiny_project

CASES = """
[frequency]
points = 21

[[requirement]]
name = "lpf_selfgravity_ltp"
outputs = ["TM1_a_x"]

[[case]]
id = "1"
title = "All areas correlated"
role = "likely"
blocks = [{ areas = ["*"] }]

[[case]]
id = "2"
title = "All areas uncorrelated"
blocks = [{ areas = ["*"], each_alone = true }]
"""
VARIANTS = """\
title = "bricks"

[[variant]]
name = "base"
project = "bricks"

[[variant]]
name = "quiet"
project = "bricks"
differs = "a tenth of the temperature noise"
set = { "cases.temperature.inside_K" = 1e-5, "cases.temperature.outside_K" = 1e-4 }

[[variant]]
name = "away"
project = "bricks/tedm.toml"
differs = "the test mass is further away"
[variant.set.model.test_mass.TM1]
position_m = [0.1, 0.3, 0.0]
"""
CRITERIA = """
[[criterion]]
name = "noise"
kind = "noise_ratio"
weight = 2

[[criterion]]
name = "mass"
kind = "mass"

[[criterion]]
name = "read-out"
kind = "noise"
outputs = ["A_TM1_x"]
"""


@dataclass(frozen=True)
class Bricks:
    """A folder with a trade: `variants.toml`, the project in `bricks`, results in `build/trade`."""

    folder: Path

    @property
    def file(self) -> Path:
        return self.folder / "variants.toml"

    @property
    def out(self) -> Path:
        return self.folder / "build" / "trade"

    def variant(self, name: str) -> Path:
        return self.out / "variants" / name

    def run(self, *arguments: object) -> Outcome:
        return tedm("trade", self.file, "-d", self.out.parent, *arguments)

    def write(self, variants: str = VARIANTS, criteria: str = CRITERIA) -> Bricks:
        self.file.write_text(variants + criteria, encoding="utf-8")
        return self

    def copy(self, folder: Path) -> Bricks:
        shutil.copytree(self.folder, folder)
        return Bricks(folder)


def make_bricks(folder: Path) -> Bricks:
    """The project, not run yet; its deck and results lie beside it."""
    project = tiny_project(folder / "bricks")
    shutil.rmtree(project.build, ignore_errors=True)
    (project.folder / "cases.toml").write_text(CASES, encoding="utf-8")
    (project.folder / "tedm.toml").write_text('title = "two bricks"\n', encoding="utf-8")
    return Bricks(folder).write()
