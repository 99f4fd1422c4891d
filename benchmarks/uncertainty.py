"""Linear propagation of materials against re-solutions of the small sample with drawn materials.

python -m benchmarks.uncertainty [DRAWS [SCALE]]: 200 draws of seven parameters where left out; SCALE multiplies their
deviations. Every draw changes the cards, solves all unit loads in memory, sums the gravity of the changed masses anew
and propagates all temperatures. The linear propagation has the same draws, and 10,000 of its own.
"""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import scipy

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.config.cases import load_cases
from tedm_cli.config.model.file import ModelConfig, load_model
from tedm_cli.config.optics.layout import load_layout
from tedm_cli.config.project import Project, load_project
from tedm_cli.contracts import OPTICS
from tedm_cli.fem.static import StaticSolution
from tedm_cli.files.store import open_checked
from tedm_cli.gravity.operator import contract
from tedm_cli.gravity.structure import stack_rows, structure_gravity
from tedm_cli.nastran.geometry import model_geometry
from tedm_cli.nastran.reading import cross_reference, deck_files, read_deck
from tedm_cli.nastran.structure.deck import solver_structure
from tedm_cli.noise.case_run import judged_outputs
from tedm_cli.noise.correlation import correlation
from tedm_cli.noise.outputs import Outputs
from tedm_cli.noise.propagation import OutputNoise, TemperatureNoise
from tedm_cli.noise.requirements import in_band
from tedm_cli.optics.chain import optics_chain
from tedm_cli.optics.law import law_matrix
from tedm_cli.progress import silent
from tedm_cli.stages.adjoint.build import build_adjoint
from tedm_cli.stages.gravity.sensitivity import build_sensitivity
from tedm_cli.stages.model.distortion import build_distortion
from tedm_cli.stages.model.ingest import ingest
from tedm_cli.stages.model.masses import distribution_of
from tedm_cli.stages.noise.case import CaseSetting, case_setting
from tedm_cli.stages.optics.build import build_optics
from tedm_cli.uncertainty.parameters import EXPANSION, MODULUS, Parameters
from tedm_cli.uncertainty.response import Effects, Ratio
from tedm_cli.uncertainty.sampling import latin_hypercube

ROOT = Path(__file__).parents[1]
SMALL = ROOT / "sample_models" / "small"
_UNCERTAIN = (
    ("zerodur", 1, "expansion", "absolute_half_width_per_K = 2e-8"),
    ("titanium", 2, "expansion", "relative_sigma = 0.02"),
    ("glass_fibre", 6, "expansion", "relative_sigma = 0.1"),
    ("zerodur", 1, "modulus", "relative_sigma = 0.01"),
    ("titanium", 2, "modulus", "relative_sigma = 0.03"),
    ("glass_fibre", 6, "modulus", 'relative_sigma = 0.15\ndistribution = "lognormal"'),
    ("titanium", 2, "density", "relative_sigma = 0.02"),
)
#: The three materials of the small sample, as those of configs/model.toml.
TABLES = "".join(
    f'\n[[uncertainty.material]]\nname = "{name}_{of}"\nmaterial = {mid}\nof = "{of}"\nsource = "-"\n{deviation}\n'
    for name, mid, of, deviation in _UNCERTAIN
)
CASES = ("2", "3", "10")
PERCENTS = (5, 50, 95)


def small_project(folder: Path) -> Project:
    """The small sample in a folder of its own, with uncertain materials."""
    model = (SMALL / "model.toml").read_text(encoding="utf-8")
    for name in ("ltp_small.bdf", "ltp_small_areas.csv", "unit_loads.bdf", "unit_loads.op2"):
        model = model.replace(f'"{name}"', f'"{SMALL / name}"')
    (folder / "model.toml").write_text(model + TABLES, encoding="utf-8")
    project = (SMALL / "tedm.toml").read_text(encoding="utf-8").replace("../../configs", str(ROOT / "configs"))
    (folder / "tedm.toml").write_text(project.replace('"thermal.toml"', f'"{SMALL}/thermal.toml"'), encoding="utf-8")
    return load_project(folder / "tedm.toml", folder / "build")


def build(project: Project) -> None:
    """Everything up to the adjoint."""
    ingest(project, None, silent)
    build_distortion(project, None, silent)
    build_sensitivity(project, None, silent)
    build_optics(project, None)
    build_adjoint(project, None, silent)


@dataclass(frozen=True, eq=False)
class Materials:
    """The uncertain materials of a project: parameters, deviations scaled, and what they do to the outputs."""

    project: Project
    model: ModelConfig
    setting: CaseSetting
    effects: Effects

    @classmethod
    def of(cls, project: Project, scale: float = 1.0) -> Materials:
        """Of a built project."""
        model = load_model(project.model)[1]
        setting = case_setting(project, *load_cases(project.cases))
        assert setting.uncertain is not None
        found = setting.uncertain.effects
        some = [i for i, item in enumerate(found.parameters.items) if item.of.startswith("MAT")]
        items = tuple(
            replace(item, deviation=scale * item.deviation) for item in (found.parameters.items[i] for i in some)
        )
        return cls(project, model, setting, Effects(Parameters.of(items), found.change[some], found.level[some]))

    def linear_rows(self, x: FloatArray) -> FloatArray:
        """Rows [n, k] of the outputs at deviations x [p], by their derivatives."""
        delta = [item.coefficient(x[i : i + 1])[0] for i, item in enumerate(self.effects.parameters.items)]
        return np.asarray(self.setting.all_outputs.rows + np.tensordot(delta, self.effects.change, axes=1))

    def solved_rows(self, x: FloatArray) -> FloatArray:
        """Rows [n, k] of the outputs with cards that have the deviations x [p]: all solved and summed anew."""
        table = self.model.model
        deck = self.project.resolve(table.deck)
        raw = read_deck(deck, cross_reference=False)
        for item, deviation in zip(self.effects.parameters.items, x.tolist(), strict=True):
            for mid in (int(word) for word in item.of.replace("MAT1", "").split(",")):
                card = raw.materials[mid]
                if item.quantity == EXPANSION:
                    card.a = card.a * (1.0 + deviation) if item.unit == "1" else card.a + deviation
                elif item.quantity == MODULUS:
                    card.e *= 1.0 + deviation
                    card.g *= 1.0 + deviation
                else:
                    card.rho *= 1.0 + deviation
        structure, cases = solver_structure(raw, deck)
        loads = [case for case in cases if case.label != table.uniform_label]
        motion = np.array([u for _, u in StaticSolution(structure).solve(loads)])
        cross_reference(raw, deck)
        masses = distribution_of(model_geometry(raw, deck_files(raw, deck)))
        how = self.model.gravity
        found = [
            structure_gravity(masses, tm, tolerance=how.quadrature_tolerance, G=how.gravitational_constant_m3_kg_s2)
            for tm in self.model.test_masses()
        ]
        rows = contract(stack_rows([f.operator for f in found]), motion[..., :3])
        rows += contract(stack_rows([f.rotation for f in found]), motion[:, masses.lever_node, 3:])
        return np.concatenate([rows, *self._read_outs(structure.grid_id, motion)])

    def _read_outs(self, grid_id: IntArray, motion: FloatArray) -> list[FloatArray]:
        assert self.project.optics is not None
        layout = load_layout(self.project.optics)[1]
        with open_checked(self.project.build_dir / "optics.h5", OPTICS) as optics:
            s_bw = optics.array(OPTICS.S_BW)
        grids = np.searchsorted(grid_id, np.array([e.grid for e in layout.bench], dtype=np.int64))
        return [one.N for one in optics_chain(layout, s_bw, motion[:, grids], P=law_matrix(layout)).sets]

    def judged(self, case_id: str) -> Iterator[tuple[str, int, OutputNoise, FloatArray]]:
        """Of the verdicts of a case: label, output, noise and limit over its band."""
        setting = self.setting
        case = setting.config.case(case_id)
        outputs: Outputs = setting.all_outputs
        found = correlation(case, outputs.areas, setting.temperature.heard)
        noise = OutputNoise(outputs.rows, TemperatureNoise(setting.temperature, found), setting.frequency_hz)
        for requirement, o in judged_outputs(setting.criteria, outputs, setting.frequency_hz):
            band = setting.frequency_hz[in_band(requirement, setting.frequency_hz)]
            limit = requirement.amplitude(band) / setting.criteria.safety_factor
            if not outputs.labels[o].startswith("B_"):  # the set B reads what A does
                yield outputs.labels[o], o, noise.at(band), limit


def drawn(materials: Materials, draws: int) -> FloatArray:
    """Deviations [draws, p] of a Latin hypercube, whose percentiles are at least as sure as of independent draws."""
    parameters = materials.effects.parameters
    return parameters.deviations(latin_hypercube(draws, len(parameters), 2026))


def compare(materials: Materials, x: FloatArray, solved: FloatArray) -> None:
    """Print each verdict's percentiles by rows `solved` [draws, n, k] at deviations x [draws, p], and by linear ones.

    The intervals of 95 % are those of percentiles of independent draws, by the binomial distribution.
    """
    rows, draws = materials.setting.all_outputs.rows, len(x)
    many = materials.effects.parameters.deviations(latin_hypercube(10_000, x.shape[1], 1))
    head = ("case", "output", "by", *(f"{p} %" for p in PERCENTS), "median, worst error")
    print("{:5}{:9}{:22}{:>21}{:>21}{:>21}{:>22}".format(*head))
    outside = 0
    for case_id in CASES:
        for label, o, noise, limit in materials.judged(case_id):
            ratio = Ratio(materials.effects.response(rows[o], o), noise, noise.frequency_hz, limit)
            exact, same = (np.sqrt(noise.of(solved[:, o]).psd()) / limit).max(axis=1), ratio.of(x)
            ordered = np.sort(exact)
            ends = []
            for percent in PERCENTS:
                low, high = scipy.stats.binom.interval(0.95, draws, percent / 100.0)
                ends.append((ordered[max(int(low) - 1, 0)], ordered[min(int(high), draws - 1)]))
            spans = "".join(f"{f'{low:.5g} .. {high:.5g}':>21}" for low, high in ends)
            print(f"{case_id:5}{label:9}{'re-solutions, 95 %':22}{spans}")
            error = np.abs(same / exact - 1.0)
            for words, found in ((f"linear, {draws} same", same), ("linear, 10,000", ratio.of(many))):
                values = np.percentile(found, PERCENTS)
                inside = [low <= value <= high for value, (low, high) in zip(values, ends, strict=True)]
                outside += inside.count(False)
                cells = (f"{v:.5g}{'' if ok else ' OUTSIDE'}" for v, ok in zip(values, inside, strict=True))
                told = f"{np.median(error):.1e}, {error.max():.1e}" if found is same else ""
                print(f"{'':14}{words:22}" + "".join(f"{cell:>21}" for cell in cells) + f"{told:>22}")
    print(f"percentiles outside their intervals: {outside} of {len(CASES) * 4 * 2 * len(PERCENTS)}")


def main(draws: int = 200, scale: float = 1.0) -> None:
    """Build the sample, solve it with drawn materials, and compare."""
    with tempfile.TemporaryDirectory() as folder:
        project = small_project(Path(folder))
        build(project)
        materials = Materials.of(project, scale)
        rows = materials.setting.all_outputs.rows
        nominal = materials.solved_rows(np.zeros(len(materials.effects.parameters)))
        off = np.abs(nominal - rows).max(axis=1) / np.abs(rows).max(axis=1)
        print(f"without deviations: rows within {off.max():.1e} of S and N")
        x = drawn(materials, draws)
        start = time.perf_counter()
        solved = np.array([materials.solved_rows(one) for one in x])
        print(f"{draws} re-solutions of {x.shape[1]} parameters: {time.perf_counter() - start:.0f} s")
        compare(materials, x, solved)


if __name__ == "__main__":
    main(*(kind(text) for kind, text in zip((int, float), sys.argv[1:], strict=False)))
