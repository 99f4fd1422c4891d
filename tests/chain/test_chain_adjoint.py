"""build-adjoint on the small sample and on the independently solved model: S_SG and N of any field, and refusals."""

from __future__ import annotations

import json
import shutil
import sys
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest
import tedm as tedm_library
from offset_mass import changed_small
from test_chain_ties import GRID, block, built

sys.path.append(str(Path(__file__).parents[1] / "borders"))

from border_tools import Outcome, edited, tedm, untouched

from tedm_cli.adjoint.temperature_field import FieldPoints, area_error
from tedm_cli.config.model.file import load_model
from tedm_cli.config.optics.layout import load_layout
from tedm_cli.config.project import Project
from tedm_cli.contracts import ADJOINT, DISTORTION, OPTICS, SENSITIVITY, UNIT_LOADS
from tedm_cli.fem.static import StaticSolution
from tedm_cli.fem.structure import LoadCase
from tedm_cli.files.store import open_checked
from tedm_cli.gravity.operator import contract
from tedm_cli.gravity.structure import stack_rows, structure_gravity
from tedm_cli.nastran.reading import read_deck
from tedm_cli.nastran.structure.deck import read_solver_deck, solver_structure
from tedm_cli.optics.chain import optics_chain
from tedm_cli.optics.law import law_matrix
from tedm_cli.progress import silent
from tedm_cli.results.adjoint.file import read_adjoint
from tedm_cli.results.unit_loads import mass_of
from tedm_cli.stages.adjoint.build import build_adjoint
from tedm_cli.stages.optics.build import build_optics

SINGLE, DOUBLE = 1e-6, 2e-10  # outputs in which motions cancel, of two ways through the same factors


def arrays(path: Path) -> dict[str, np.ndarray]:
    with open_checked(path, ADJOINT) as file:
        return {d: file.array(d) for d, one in ADJOINT.datasets.items() if file.has(d) and one.dtype != "str"}


@pytest.fixture(scope="module")
def adjoint(small: Project) -> Path:
    return small.build_dir / "adjoint.h5"


def by_motion(project: Project, motion: np.ndarray) -> np.ndarray:
    """Accelerations and read-outs [r, k] by motions [k, N, 6] of all grids, by the chain's contraction and optics."""
    with (
        open_checked(project.build_dir / "sensitivity.h5", SENSITIVITY) as gravity,
        open_checked(project.build_dir / "optics.h5", OPTICS) as optics,
    ):
        lever = gravity.array(SENSITIVITY.OPERATOR_OFFSET_NODE)
        found = contract(gravity.array(SENSITIVITY.OPERATOR_G), motion[..., :3])
        found += contract(gravity.array(SENSITIVITY.OPERATOR_G_ROTATION), motion[:, lever, 3:])
        assert project.optics is not None
        _, layout = load_layout(project.optics)
        grids = np.array([e.grid for e in layout.bench], dtype=np.int64)
        rows = np.searchsorted(gravity.array(SENSITIVITY.GRID_ID), grids)
        chain = optics_chain(layout, optics.array(OPTICS.S_BW), motion[:, rows], P=law_matrix(layout))
    return np.concatenate([found, *(one.N for one in chain.sets)])


def agree(found: np.ndarray, wanted: np.ndarray, digits: float) -> None:
    """Over the largest of all accelerations, angular accelerations, lengths, and angles."""
    for part in (slice(6), slice(6, 12), [12, 15, 18, 21], [13, 14, 16, 17, 19, 20, 22, 23]):
        size = np.abs(wanted[part]).max()
        assert size > 0.0
        assert np.abs(found[part] - wanted[part]).max() < digits * size


def test_sums_over_areas_are_the_matrices(small: Project, adjoint: Path) -> None:
    """To single precision, in which the results are kept; and what the file says of that is so."""
    found = arrays(adjoint)
    with (
        open_checked(small.build_dir / "sensitivity.h5", SENSITIVITY) as gravity,
        open_checked(small.build_dir / "optics.h5", OPTICS) as optics,
        open_checked(adjoint, ADJOINT) as file,
    ):
        sets = optics.strings(OPTICS.SET_NAME)
        wanted = np.concatenate([gravity.array(SENSITIVITY.S), *(optics.array(OPTICS.N.of(s)) for s in sets)])
        labels = optics.strings(OPTICS.LABEL_READ_OUT)
        assert file.strings(ADJOINT.ROW_LABEL) == [
            *gravity.strings(SENSITIVITY.ROW_LABEL),
            *(f"{name}_{label}" for name in sets for label in labels),
        ]
        results = read_adjoint(file)
    agree(found["/area/sum"], wanted, SINGLE)
    assert not found["/direct"].any()
    assert 0.0 < found["/check/difference"].max() < SINGLE
    assert (found["/check/allowed"] >= SINGLE).all()
    assert found["/check/allowed"].max() < 3.0 * SINGLE, "rounding is no excuse for more"
    assert not isinstance(results, str)
    np.testing.assert_array_equal(results.value, found["/area/sum"])


def test_whole_elements_are_the_model(adjoint: Path) -> None:
    """Together they are 1 K everywhere, in double precision, and all of the volume."""
    found = arrays(adjoint)
    agree(found["/map/s"].sum(axis=1, keepdims=True), found["/s"].sum(axis=1, keepdims=True), DOUBLE)
    assert found["/map/volume"].sum() == pytest.approx(found["/grid/volume"].sum(), rel=1e-12)
    assert (found["/map/volume"] > 0.0).all()
    lines = np.isin(found["/map/element_id"], found["/element/id"])
    np.testing.assert_allclose(found["/map/s"][:, lines], found["/element/mean"], rtol=1e-9, atol=0)
    np.testing.assert_array_equal(found["/map/volume"][lines], found["/element/volume"])


def test_values_are_found_by_their_names(adjoint: Path) -> None:
    """From Python: output, grid and area, as h5py finds them in the file."""
    found = tedm_library.open_build(adjoint.parent).adjoint
    with h5py.File(adjoint) as file:
        rows, areas = (list(file[path].asstr()[()]) for path in ("row/label", "area/name"))
        a_x, eta, area = rows.index("TM1_a_x"), rows.index("A_TM2_eta"), areas.index("STRUT_5")
        node = int(np.abs(file["s"][a_x]).argmax())
        grid = int(file["grid/id"][node])
        wanted = [file["s"][a_x, node], file["area/sum"][eta, area], file["area/gradient"][eta, area, 2]]
    of_read_out = found.sel(row="A_TM2_eta", area="STRUT_5")
    by_name = [found.s.sel(row="TM1_a_x", node=grid), of_read_out.area_sum, of_read_out.area_gradient.sel(xyz="z")]
    assert [float(value) for value in by_name] == wanted
    assert all(wanted)
    assert (of_read_out.row_unit.item(), of_read_out.area_group.item()) == ("rad/K", "struts")
    assert found.s.attrs["units"] == "per K, see row_unit"
    assert found.element_mean.dims == ("row", "element")
    assert "refusal" not in found


def test_unit_loads_and_any_field_solved_in_memory(small: Project, adjoint: Path) -> None:
    """In double precision: the areas by the deck's own load cases, and ten fields of any temperatures at all grids."""
    found = arrays(adjoint)
    structure, cases = read_solver_deck(Path(small.resolve("unit_loads.bdf")))
    rng = np.random.default_rng(11)
    first = cases[0].temperature
    assert first is not None
    rest = first.min()
    steps = rng.uniform(-1.0, 1.0, (10, structure.n_grids))
    fields = [LoadCase(id=900 + k, label="", temperature=rest + step) for k, step in enumerate(steps)]
    motion = np.array([u for _, u in StaticSolution(structure).solve([*cases, *fields])])
    wanted = by_motion(small, motion)
    assert cases[-1].label == "UNIFORM"
    n = len(cases) - 1
    agree(found["/area/sum"], wanted[:, :n], DOUBLE)
    agree(found["/s"].sum(axis=1, keepdims=True), wanted[:, n : n + 1], DOUBLE)
    agree(found["/s"] @ steps.T, wanted[:, n + 1 :], DOUBLE)
    assert not found["/element/own"].any()


def test_materials_are_what_a_changed_deck_does(small: Project, adjoint: Path) -> None:
    """The modulus and the expansion of the struts, by cards that are changed, solved in memory, through the chain."""
    found = arrays(adjoint)
    row = found["/material/id"].tolist().index(6)
    assert found["/material/expansion"][row] == 7e-6

    def value(**change: float) -> np.ndarray:
        path = Path(small.resolve("unit_loads.bdf"))
        raw = read_deck(path, cross_reference=False)
        for name, factor in change.items():
            setattr(raw.materials[6], name, factor * getattr(raw.materials[6], name))
        structure, cases = solver_structure(raw, path)
        return by_motion(small, np.array([u for _, u in StaticSolution(structure).solve(cases[:-1])]))

    up, down = value(e=1.001, g=1.001), value(e=0.999, g=0.999)
    agree(found["/material/dS_dlnE"][row], (up - down) / 0.002, 1e-5)
    by_one = (value(a=1.5) - value(a=0.5)) / 7e-6
    agree(found["/material/dS_dalpha"][row], by_one, 1e-9)
    agree(found["/material/dS_dlnalpha"][row], 7e-6 * by_one, 1e-9)


def test_materials_sum_to_the_matrices(small: Project, adjoint: Path) -> None:
    """All expansions; all densities, with the two concentrated masses; a factor of all moduli is nothing."""
    found = arrays(adjoint)
    agree(found["/material/dS_dlnalpha"].sum(axis=0), found["/area/sum"], 1e-9)
    assert not found["/material/dS_dlnrho"][:, 12:].any()
    _, config = load_model(small.model)
    with (
        open_checked(small.build_dir / "unit_loads.h5", UNIT_LOADS) as unit,
        open_checked(small.build_dir / "distortion.h5", DISTORTION) as distortion,
    ):
        points = replace(mass_of(unit), elements=())
        motion = distortion.array(DISTORTION.D_TRANSLATION)
    assert points.total_kg == pytest.approx(0.24)
    pulls = [structure_gravity(points, tm, tolerance=1e-6) for tm in config.test_masses()]
    weighs = found["/material/dS_dlnrho"].sum(axis=0)
    weighs[:12] += contract(stack_rows([one.operator for one in pulls]), motion)
    weighs[12:] = found["/area/sum"][12:]
    agree(weighs, found["/area/sum"], SINGLE)
    moduli = found["/material/dS_dlnE"]
    for part in (slice(6), slice(6, 12), [12, 15, 18, 21], [13, 14, 16, 17, 19, 20, 22, 23]):
        assert np.abs(moduli.sum(axis=0)[part]).max() < 10.0 * SINGLE * np.abs(moduli[:, part]).max()
    assert found["/shell/dS_dlnt"].shape == (0, 24, 28)


def test_materials_are_ranked_by_what_a_little_more_does(adjoint: Path) -> None:
    """`tedm show` says the change of an rms that the file gives when its matrices are changed by a hundredth."""
    shown = json.loads(tedm("show", adjoint, "--json").ok().out)["materials"]
    found, sizes = arrays(adjoint), [abs(m["change"]) for m in shown]
    assert sizes == sorted(sizes, reverse=True)
    paths = {"modulus": "dS_dlnE", "expansion": "dS_dlnalpha", "density": "dS_dlnrho"}
    assert {m["quantity"] for m in shown} == set(paths)
    with open_checked(adjoint, ADJOINT) as file:
        labels, areas = file.strings(ADJOINT.ROW_LABEL), file.strings(ADJOINT.AREA_NAME)
    value = found["/area/sum"] + found["/direct"]
    for one in shown:
        material = found["/material/id"].tolist().index(int(one["of"].removeprefix("MAT1 ")))
        change = found[f"/material/{paths[one['quantity']]}"][material]
        rms = [np.linalg.norm(value + step * change, axis=1) for step in (-1e-4, 1e-4)]
        every = (rms[1] - rms[0]) / 2e-4 / np.linalg.norm(value, axis=1)
        row = labels.index(one["output"])
        assert one["change"] == pytest.approx(every[row], rel=1e-5, abs=1e-9)
        assert abs(one["change"]) == pytest.approx(np.abs(every).max(), rel=1e-5, abs=1e-9)
        terms = np.abs(value[row] * change[row])
        assert terms[areas.index(one["area"])] == pytest.approx(terms.max(), rel=1e-6)
    assert next(m["used_by"] for m in shown if m["of"] == "MAT1 6") == "PBAR 10"
    few = tedm("show", adjoint, "--top", "3").ok().out
    assert f"and {len(shown) - 3} more (--top 0: all)" in few
    assert f"{shown[0]['of']} {shown[0]['quantity']}" in few


def test_areas_against_an_even_field(small: Project, adjoint: Path) -> None:
    """By whole matrices: C of all grids, and of the areas' means weighted by volume; 1 where the field is even."""
    found = arrays(adjoint)
    with open_checked(small.build_dir / "unit_loads.h5", UNIT_LOADS) as unit:
        position = unit.array(UNIT_LOADS.GRID_POSITION)
        offset, index = unit.array(UNIT_LOADS.AREA_NODE_OFFSET), unit.array(UNIT_LOADS.AREA_NODE_INDEX)
    k = len(offset) - 1
    grids = np.sort(index)
    of_area = np.zeros((len(grids), k))
    of_area[np.searchsorted(grids, index), np.repeat(np.arange(k), np.diff(offset))] = 1.0
    volume = np.abs(found["/grid/volume"][grids])
    weight = of_area * volume[:, None] / (volume @ of_area)
    s = found["/s"][:, grids]
    distance = np.linalg.norm(position[grids, None] - position[grids], axis=2)

    def spread(rows: np.ndarray, covariance: np.ndarray) -> np.ndarray:
        return np.sqrt(np.einsum("rn,nm,rm->r", rows, covariance, rows))

    for number, length in enumerate(found["/field/length"]):
        covariance = np.exp(-distance / length)
        exact, means = spread(s, covariance), weight.T @ covariance @ weight
        np.testing.assert_allclose(found["/field/ratio"][number], spread(s @ of_area, means) / exact, rtol=1e-9)
        left = spread(s - s @ of_area @ weight.T, covariance) / exact
        np.testing.assert_allclose(found["/field/left_out"][number], left, rtol=1e-6)
    assert found["/field/ratio"].min() < 0.9, "these areas are coarse"
    points = FieldPoints(position=position[grids], volume=volume, sensitivity=s)
    error = area_error(points, of_area.argmax(axis=1), [1e12])
    felt = np.abs(s.sum(axis=1)) > 1e-3 * np.abs(s).sum(axis=1)
    assert felt.sum() > 6
    np.testing.assert_allclose(error.ratio[0, felt], 1.0, rtol=1e-6)


def test_what_cancels_is_named(adjoint: Path) -> None:
    """By area and output, the worst first: their gradient is what there is to hide. Not what is zero by symmetry."""
    with open_checked(adjoint, ADJOINT) as file:
        found = read_adjoint(file)
    assert not isinstance(found, str)
    worst = found.cancelling_most
    factors = [one.factor for one in worst]
    assert factors == sorted(factors, reverse=True)
    assert 1.0 <= factors[-1] < 10.0 < factors[0] < 1e8
    names = found.areas.name.tolist()
    for one in worst[:5]:
        row, column = found.label.index(one.output), names.index(one.area)
        assert one.factor == found.cancellation[row, column]
        assert one.factor * abs(found.value[row, column]) > 1e-2 * np.abs(found.value[row]).max()
    assert {one.output for one in worst} == {label for label, felt in zip(found.label, found.felt, strict=True) if felt}


def test_the_independently_solved_model(mini: Project, tmp_path: Path) -> None:
    """Its unit loads are another solver's; it has no read-outs, whose layout cannot be traced."""
    done = build_adjoint(mini, tmp_path / "adjoint.h5", silent)
    assert "optics.h5 is not there" in done.no_read_outs
    with open_checked(mini.build_dir / "sensitivity.h5", SENSITIVITY) as file:
        wanted = file.array(SENSITIVITY.S)
    found = arrays(done.path)["/area/sum"]
    for rows in (slice(6), slice(6, 12)):
        assert np.abs(found[rows] - wanted[rows]).max() < SINGLE * np.abs(wanted[rows]).max()


@pytest.fixture(scope="module")
def heavy(tmp_path_factory: pytest.TempPathFactory) -> Project:
    """The small sample with a mass on a lever, a tied block, and a test mass and a plate that change with areas; no
    cases."""
    folder = tmp_path_factory.mktemp("heavy")
    project = changed_small(folder, f"CONM2,900077,{GRID},,0.5,0.05,0.02,0.03\n", block("CM1", f"grid = {GRID}"))
    assert project.optics is not None
    text = project.optics.read_text(encoding="utf-8")
    expansion = '\n[[test_mass_expansion]]\ntest_mass = "TM1"\nexpansion_per_K = 1.65e-5\narea = "IS1_EH_UP"\n'
    splitter = 'name = "BS4"\n'
    glass = splitter + 'dn_dT_1_K = 8.3e-6\nexpansion_1_K = 5.2e-7\narea = "OB_BENCH_PLUS_Y"\n'
    (folder / "optics.toml").write_text(text.replace(splitter, glass) + expansion, encoding="utf-8")
    project = replace(project, optics=folder / "optics.toml")
    built(project)
    build_optics(project, None)
    return project


def test_levers_tied_masses_faces_and_plates_are_in_it(heavy: Project, tmp_path: Path) -> None:
    path = build_adjoint(heavy, tmp_path / "adjoint.h5", silent).path
    found = arrays(path)
    assert found["/check/difference"].max() < SINGLE
    with (
        open_checked(heavy.build_dir / "sensitivity.h5", SENSITIVITY) as gravity,
        open_checked(heavy.build_dir / "optics.h5", OPTICS) as optics,
    ):
        turning = np.abs(gravity.array(SENSITIVITY.OPERATOR_G_ROTATION)).max(axis=(1, 2))
        wanted = np.concatenate([optics.array(OPTICS.N.of(s)) for s in optics.strings(OPTICS.SET_NAME)])
        column, glass = (optics.strings(OPTICS.AREA_NAME).index(n) for n in ("IS1_EH_UP", "OB_BENCH_PLUS_Y"))
        plates = np.concatenate([optics.array(OPTICS.N_PLATES.of(s)) for s in optics.strings(OPTICS.SET_NAME)])
    assert (turning > 0.0).all()
    assert not found["/direct"][:12].any()
    direct = found["/direct"][12:]
    assert np.abs(direct[:, column]).max() > 1e-3 * np.abs(wanted[:, column]).max()
    assert not np.delete(direct, [column, glass], axis=1).any()
    assert direct[:, glass] == pytest.approx(plates[:, glass], rel=1e-12, abs=1e-20)
    assert np.abs(plates[:, glass]).max() > 1e-8
    for part in ([0, 3, 6, 9], [1, 2, 4, 5, 7, 8, 10, 11]):
        size = np.abs(wanted[part]).max()
        assert np.abs(found["/area/sum"][12:][part] + direct[part] - wanted[part]).max() < SINGLE * size


# --- refusals --------------------------------------------------------------------------------------------------------


class Shop:
    """A copy of the heavy sample whose files have been built, to be changed and said to be so."""

    def __init__(self, source: Project, folder: Path) -> None:
        shutil.copytree(source.build_dir.parent, folder)
        self.folder, self.build = folder, folder / "build"
        settings = (folder / "tedm.toml").read_text(encoding="utf-8")
        lines = [line for line in settings.splitlines() if not line.startswith("optics")]
        (folder / "tedm.toml").write_text("\n".join(['optics = "optics.toml"', *lines]) + "\n", encoding="utf-8")

    def run(self, *words: str) -> Outcome:
        command, *options = words
        return tedm(command, *options, "-c", self.folder / "tedm.toml", "-d", self.build)

    def again(self, old: str, new: str) -> None:
        """Change the deck, and make all files that follow from it."""
        deck = self.folder / "unit_loads.bdf"
        text = deck.read_text(encoding="ascii")
        assert old in text
        deck.write_text(text.replace(old, new), encoding="ascii")
        (self.build / "optics.h5").unlink()
        for command in ("ingest", "build-distortion", "build-sensitivity"):
            self.run(command).ok()


@pytest.fixture
def shop(heavy: Project, tmp_path: Path) -> Shop:
    return Shop(heavy, tmp_path / "shop")


def test_it_says_what_it_has_made(shop: Shop) -> None:
    said = shop.run("build-adjoint").ok().out
    assert "24 outputs by the temperatures of 570 grids and of 32 shells, bars and rods\n" in said
    assert "sums over the 28 areas are their unit loads, within" in said
    assert "largest_difference" in tedm("show", shop.build / "adjoint.h5").ok().out


def refused(shop: Shop, code: int, *pieces: str, hint: str = "") -> None:
    """Without and with --or-say-why, where the file, and what is shown of it, say the same."""
    with untouched(shop.build):
        shop.run("build-adjoint").refused(code, "unit_loads.bdf", *pieces, hint=hint)
    said = [shop.run("build-adjoint", "--or-say-why").ok().out, tedm("show", shop.build / "adjoint.h5").ok().out]
    with open_checked(shop.build / "adjoint.h5", ADJOINT) as file:
        why = read_adjoint(file)
        assert not file.has(ADJOINT.S)
        assert file.strings(ADJOINT.AREA_NAME)
    assert isinstance(why, str)
    assert str(shop.folder) not in why
    assert why in "\n".join(tedm_library.open_build(shop.build).adjoint.refusal.values)
    for piece in pieces:
        assert all(piece in text for text in (why, *said))


def test_what_has_no_coupling_is_refused_by_id(shop: Shop) -> None:
    """Elements of other cards, rigid elements that expand, materials that depend on temperature: all at once."""
    cards = [
        "CELAS2,77001,1.+3,850001,1,850002,1",
        "CELAS2,77002,1.+3,850001,2,850002,2",
        "RBE2,77003,850001,123,850002,1.-5",
        "MATT1,1,7",
        "TABLEM1,7\n,0.,1.,1.,1.,ENDT",
    ]
    shop.again("ENDDATA", "\n".join([*cards, "ENDDATA"]))
    pieces = ("CELAS2 77001, 77002", "RBE2 that expands (ALPHA) 77003", "MATT1 1, which depends on temperature")
    refused(shop, 4, "no thermal coupling", *pieces, hint="The embedded solver")
    shop.run("write-deck", "--adjoint").refused(4, "no thermal coupling", *pieces, hint="The embedded solver")
    assert not (shop.folder / "adjoint_loads.bdf").exists()


def test_sums_that_are_not_the_unit_loads_name_area_and_output(shop: Shop) -> None:
    """As where another solver's elements are others: the largest difference is named, and how many there are."""
    with edited(shop.build / "sensitivity.h5") as file:
        row, column = np.unravel_index(np.abs(file["S"][:6]).argmax(), (6, 28))
        file["S"][row, column] *= 1.0 + 3e-5
        label, area = file["row/label"][row].decode(), file["area/name"][column].decode()
    refused(shop, 5, f"area '{area}'", label, "3e-05 of the largest", "allowed 1.0e-06", "(1 of 672 sums)")


def test_files_that_are_missing_or_stale_are_refused(shop: Shop) -> None:
    (shop.build / "optics.h5").rename(shop.build / "aside.h5")
    said = shop.run("build-adjoint").ok().out
    assert "12 outputs" in said
    assert "optics.h5 is not there: `tedm build-optics` makes it" in said
    (shop.build / "aside.h5").rename(shop.build / "optics.h5")
    with (shop.folder / "unit_loads.bdf").open("a") as deck:
        deck.write("$ another deck\n")
    for more in ([], ["--or-say-why"]):
        shop.run("build-adjoint", *more).refused(4, "unit_loads.h5: is stale", hint="tedm ingest")
    deck_file = shop.folder / "unit_loads.bdf"
    deck_file.write_text(deck_file.read_text().replace("$ another deck\n", ""))
    with (shop.folder / "optics.toml").open("a") as layout:
        layout.write("# another layout\n")
    shop.run("build-adjoint").refused(4, "optics.h5: is stale", hint="tedm build-optics")
    (shop.build / "sensitivity.h5").unlink()
    shop.run("build-adjoint").refused(4, "sensitivity.h5: no such file", hint="tedm build-sensitivity")
