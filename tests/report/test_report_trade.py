"""A trade of variants: criteria as read from results, trade.h5, the page, and its figure."""

from __future__ import annotations

import re
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from figure_texts import drawn, overlaps, texts
from matplotlib.figure import Figure

from tedm_cli.config.project import Project
from tedm_cli.config.trade import CriterionTable
from tedm_cli.contracts import TRADE
from tedm_cli.contracts.trade import GOALS
from tedm_cli.figures.parallel import parallel_figure, scale_of
from tedm_cli.files.provenance import Provenance, input_files
from tedm_cli.files.store import create, open_checked
from tedm_cli.results.gravity.field import dc_verdicts
from tedm_cli.results.trade import Cell, Trade, TradedCriterion, TradedVariant, compared, read_trade, write_trade
from tedm_cli.stages.trade.criteria import Measured, commands, measured
from tedm_cli.stages.trade.found import LacksError, VariantResults
from tedm_cli.stages.trade.page import write_page

# --- criteria ---


def value(project: Project, kind: str, **keys: Any) -> Measured:
    return measured(CriterionTable(name="c", kind=kind, **keys), VariantResults(project))


def judged(project: Project, case: str, column: str) -> dict[tuple[str, str], float]:
    with h5py.File(project.build_dir / f"case{case}.h5") as file:
        names = zip(file["/verdict/output"].asstr(), file["/verdict/requirement"].asstr(), strict=True)
        return dict(zip(names, file[column][()].tolist(), strict=True))


def test_ratios_of_a_case(finished: Project) -> None:
    ratio = judged(finished, "01", "/verdict/ratio")
    read_outs = {o: r for (o, q), r in ratio.items() if q == "lpf_readout_item"}
    assert value(finished, "noise_ratio", case="1").value == max(ratio.values())
    found = value(finished, "noise_ratio", case="1", requirement="lpf_readout_item")
    assert found.value == max(read_outs.values())
    one = value(finished, "noise_ratio", case="1", outputs=["B_TM2_x"])
    assert one.value == read_outs["B_TM2_x"]
    assert one.of.startswith("B_TM2_x, case 1, ")
    distortion = judged(finished, "01", "/verdict/distortion_ratio")
    assert value(finished, "distortion_ratio", case="1").value == np.nanmax(list(distortion.values()))
    assert value(finished, "bound_ratio", case="1").value >= max(ratio.values())


def test_without_a_case_those_count_that_can_occur(finished: Project) -> None:
    """None of these is likely, and none diagnostic: the largest of all."""
    each = [max(judged(finished, case, "/verdict/ratio").values()) for case in ("01", "02", "4b")]
    assert value(finished, "noise_ratio").value == max(each)
    of = VariantResults(finished)
    criterion = CriterionTable(name="c", kind="noise_ratio")
    assert commands(criterion, of) == [("run-case", "1"), ("run-case", "2"), ("run-case", "4b")]
    assert commands(criterion.model_copy(update={"case": "9"}), of) == []
    assert commands(CriterionTable(name="c", kind="mass"), of) == [("ingest",)]
    assert commands(CriterionTable(name="c", kind="closed_loop_ratio", case="2"), of) == [("simulate", "2")]


def test_contributors_sum_to_the_square_of_the_ratio(finished: Project) -> None:
    found = value(finished, "noise_ratio", case="1", outputs=["A_TM1_x"])
    assert sum(found.parts.values()) == pytest.approx(found.value**2)
    groups = value(finished, "noise_ratio", case="1", outputs=["A_TM1_x"], contributors="groups")
    assert groups.parts["struts"] == pytest.approx(found.parts["STRUT_1"] + found.parts["STRUT_2"])
    assert sum(groups.parts.values()) == pytest.approx(found.value**2)


def test_noise_at_a_frequency(finished: Project) -> None:
    with h5py.File(finished.build_dir / "case02.h5") as file:
        f, psd = file["/frequency"][()], file["/psd/TM1_a_y"][()]
    at = int(np.abs(f - 1e-3).argmin())
    assert f[at] == pytest.approx(1e-3)
    found = value(finished, "noise", case="2", outputs=["TM1_a_y"])
    assert found.value == pytest.approx(np.sqrt(psd[at]))
    assert found.unit == "m s^-2/√Hz"
    between = value(finished, "noise", case="2", outputs=["TM1_a_y"], frequency_hz=float(np.sqrt(f[at] * f[at + 1])))
    assert between.value == pytest.approx((psd[at] * psd[at + 1]) ** 0.25)


def test_closed_loop(finished: Project) -> None:
    with h5py.File(finished.build_dir / "simulation01.h5") as file:
        outputs, ratio = file["/verdict/output"].asstr()[()], file["/verdict/ratio"][()]
    of_delta_g = ratio[outputs == "delta_g"].max()
    found = value(finished, "closed_loop_ratio", case="1")
    assert found.value == of_delta_g
    assert sum(found.parts.values()) == pytest.approx(of_delta_g**2)
    assert (
        value(finished, "closed_loop_ratio", case="1", outputs=["TM1_a_x"]).value == ratio[outputs == "TM1_a_x"].max()
    )
    with h5py.File(finished.build_dir / "simulation01.h5") as file:
        names = file["/requirement/name"].asstr()[()].tolist()
        thermal = [
            float(file["/case/safety_factor"][()])
            * np.nanmax(
                np.sqrt(file["/contribution/thermal/delta_g"][()]) / file["/requirement/amplitude"][names.index(q)]
            )
            for q, o in zip(file["/verdict/requirement"].asstr()[()], outputs, strict=True)
            if o == "delta_g"
        ]
    alone = value(finished, "closed_loop_thermal_ratio", case="1").value
    assert alone == pytest.approx(max(thermal))
    assert found.parts["thermal"] ** 0.5 <= alone * (1 + 1e-9) < found.value


def test_at_rest(finished: Project) -> None:
    from tedm_cli.contracts import SENSITIVITY

    with open_checked(finished.build_dir / "sensitivity.h5", SENSITIVITY) as file:
        verdicts = dc_verdicts(file)
    assert value(finished, "rest_ratio").value == max(v.ratio for v in verdicts)
    violations = value(finished, "rest_violations")
    assert violations.value == sum(not v.passed for v in verdicts)
    assert violations.of == f"of {len(verdicts)} limits"
    whole = next(v for v in verdicts if v.whole and v.quantity == "a_x")
    found = value(finished, "rest_ratio", subsystem=whole.subsystem, quantities=["a_x"])
    assert found.value == whole.ratio
    assert list(found.parts) == ["structure", "other test mass", "compensation masses"]
    assert sum(found.parts.values()) == pytest.approx(whole.ratio)
    gradient = next(v for v in verdicts if v.whole and v.quantity == "gamma_xx")
    of_gradient = value(finished, "rest_ratio", subsystem=gradient.subsystem, quantities=["gamma_xx"])
    assert sum(of_gradient.parts.values()) == pytest.approx(of_gradient.value)
    assert value(finished, "rest_ratio", subsystem="IS").parts == {}, "of a part of the model there are none"


def test_masses(finished: Project) -> None:
    found = value(finished, "mass")
    assert found.value == 6.5
    assert found.parts == pytest.approx({"struts": 0.5, "OB": 3.0, "IS1": 3.0})
    blocks = value(finished, "compensation_mass")
    assert blocks.value == pytest.approx(sum(blocks.parts.values()))


LACKED = {
    "unknown case": ("noise_ratio", {"case": "7"}, "has no case 7"),
    "unknown output": ("noise_ratio", {"outputs": ["A_TM1_y"]}, "has no A_TM1_y; the nearest is A_TM1_x"),
    "another requirement": (
        "noise_ratio",
        {"outputs": ["TM1_a_x"], "requirement": "lpf_readout_item"},
        "judges nothing of this",
    ),
    "no read-out": ("distortion_ratio", {"requirement": "lpf_selfgravity_ltp"}, "judges no read-out"),
    "outputs of two units": ("noise", {"outputs": ["TM1_a_x", "A_TM1_x"]}, "no one of them is the largest"),
    "a frequency beyond": ("noise", {"outputs": ["TM1_a_x"], "frequency_hz": 10.0}, "has no noise at 1e+04 mHz"),
    "nothing uncertain": ("probability", {}, "says of nothing how uncertain it is"),
    "unknown subsystem": ("rest_ratio", {"subsystem": "S/C"}, "judges nothing of this at rest (subsystems "),
}


@pytest.mark.parametrize(("kind", "keys", "reason"), LACKED.values(), ids=LACKED)
def test_what_a_variant_lacks(finished: Project, kind: str, keys: dict[str, Any], reason: str) -> None:
    with pytest.raises(LacksError, match=re.escape(reason)):
        value(finished, kind, **keys)


# --- trade.h5 and the page ---


def trade_of(variants: int, criteria: int = 8, seed: int = 1, empty: float = 0.1) -> Trade:
    """Made-up values, of which some are empty; names as users may write them."""
    rng = np.random.default_rng(seed)
    kinds = [
        ("read-out, case 3", "1", "min", 1.0, "part of ratio²"),
        ("self-gravity as a whole, <likely> & $cases$", "1", "min", 1.0, ""),
        ("mass", "kg", "min", None, "kg"),
        ("first frequency", "Hz", "max", 60.0, ""),
        ("limits at rest violated", "1", "min", 0.0, ""),
        ("noise at 1 mHz", "m s^-2/√Hz", "min", None, ""),
        ("all alike", "1", "min", 1.0, ""),
        ("what no variant has", "", "min", None, ""),
    ][:criteria]
    told = tuple(TradedCriterion(n, "noise", f"what {n} is", u, g, limit, 1.0, p) for n, u, g, limit, p in kinds)
    scale = {"1": 0.7, "kg": 200.0, "Hz": 70.0, "m s^-2/√Hz": 1e-15}
    cells = []
    for _ in range(variants):
        row = []
        for c in told:
            size = {"all alike": 0.5}.get(c.name, scale.get(c.unit, 1.0) * float(np.exp(rng.normal())))
            if c.name == "what no variant has" or (rng.random() < empty and c.name != "all alike"):
                row.append(Cell(None, "has no such thing"))
                continue
            passed = None if c.limit is None else bool(size <= c.limit if c.goal == GOALS[0] else size >= c.limit)
            total = size**2 if "²" in c.parts else size
            row.append(
                Cell(
                    size,
                    "",
                    "TM1_a_x, case 3, 1 mHz",
                    passed,
                    {"STRUT_1": 1.5 * total, "OB_1": -0.5 * total} if c.parts else {},
                )
            )
        cells.append(row)
    named = [
        TradedVariant(f"variant_{i}", "a title", f"what <differs> in {i}", f"variants/{i}", "") for i in range(variants)
    ]
    if variants > 2:
        named[1] = replace(named[1], failure="the solver says: matrix singular")
        cells[1] = [Cell(None, "its chain failed")] * len(told)
    return compared("A trade of <many> & $more$", named, told, cells)


def stored(trade: Trade, folder: Path) -> Path:
    path = folder / "trade.h5"
    with create(path, TRADE, Provenance((), input_files([]), "tedm trade")) as writer:
        write_trade(writer, trade)
    return path


@pytest.mark.parametrize("variants", [1, 2, 30])
def test_what_is_written_is_read(tmp_path: Path, variants: int) -> None:
    trade = trade_of(variants)
    with open_checked(stored(trade, tmp_path), TRADE) as file:
        again = read_trade(file)
    assert (again.title, again.variants, again.criteria, again.cells) == (
        trade.title, trade.variants, trade.criteria, trade.cells,
    )  # fmt: skip
    assert again.dominates.tolist() == trade.dominates.tolist()


def test_empty_is_not_zero_in_the_file(tmp_path: Path) -> None:
    trade = trade_of(3)
    with h5py.File(stored(trade, tmp_path)) as file:
        values, reasons = file["/cell/value"][()], file["/cell/reason"].asstr()[()]
        assert np.isnan(values[1]).all()
        assert (reasons[1] == "its chain failed").all()
        assert (np.isnan(values) == (reasons != "")).all()
        assert file["/variant/front"][1] == 0


def test_the_page_in_all_formats(tmp_path: Path) -> None:
    trade = trade_of(4)
    report = tmp_path / "variants" / "2" / "report.html"
    report.parent.mkdir(parents=True)
    report.touch()
    written = write_page(stored(trade, tmp_path))
    assert [p.relative_to(tmp_path).as_posix() for p in written] == [
        *("trade.html", "trade.pdf", "trade.md", "figures/parallel.svg")
    ]
    text = (tmp_path / "trade.md").read_text(encoding="utf-8")
    page = (tmp_path / "trade.html").read_text(encoding="utf-8")
    assert "variants/2/report.html" in text
    assert 'href="variants/2/report.html"' in page
    assert "variants/0/report.html" not in page
    assert "&rarr;" not in page, "there is no annex to lead to"
    assert "what &lt;differs&gt; in 2" in page
    assert "$more$" in page
    assert "matrix singular" in text
    assert "![" in text
    front = re.search(r"\*\*(.+?)\*\* (?:is|are) on the Pareto front of 3 variants", text)
    assert front is not None
    assert front[1].replace(" and ", ", ").split(", ") == [n.replace("_", "_") for n in trade.front]
    again = {p: p.read_bytes() for p in written}
    assert {p: p.read_bytes() for p in write_page(tmp_path / "trade.h5")} == again, "the same bytes"


def test_a_table_of_the_page_has_every_value(tmp_path: Path) -> None:
    trade = trade_of(5)
    write_page(stored(trade, tmp_path))
    text = (tmp_path / "trade.md").read_text(encoding="utf-8")
    tables = text.partition("## Variants by criteria")[2].partition("## What has changed")[0]
    for variant, cells in zip(trade.variants, trade.cells, strict=True):
        rows = [line for line in tables.splitlines() if line.startswith(f"| {variant.name} |")]
        for criterion, cell in zip(trade.criteria, cells, strict=True):
            if cell.value is not None:
                said = criterion.text(cell.value)
                assert any(re.search(rf"\| \**{re.escape(said)}[ *\\]", row) for row in rows), (
                    variant.name,
                    said,
                    rows,
                )
        assert sum(row.count("| – |") + row.count("| – | –") for row in rows) > 0, "what no variant has is empty"


def test_the_best_is_marked_where_others_are_worse() -> None:
    criterion = TradedCriterion("c", "mass", "w", "kg", "min", None, 0.0, "")
    variants = [TradedVariant(name, "", "", name, "") for name in "abc"]

    def of(*values: float | None) -> Trade:
        cells = [[Cell(v, "" if v is not None else "lacks it")] for v in values]
        return compared("t", variants, [criterion], cells)

    assert of(1.0, 1.0, 2.0).marked(0) == of(1.0, 1.0, 2.0).best_by(0) == ["a", "b"]
    assert of(1.0, None, 2.0).marked(0) == ["a"]
    assert (of(1.0, 1.0, None).marked(0), of(1.0, 1.0, None).best_by(0)) == ([], ["a", "b"])
    assert of(None, None, None).best_by(0) == []


def test_parts_tell_what_has_changed(tmp_path: Path) -> None:
    criterion = TradedCriterion("noise", "noise_ratio", "w", "1", "min", 1.0, 0.0, "part of ratio²")
    cells = [
        [Cell(3.0, "", "x", False, {"STRUT": 8.0, "OB": 1.0})],
        [Cell(2.0, "", "x", False, {"BIPOD": 3.0, "OB": 1.0})],
    ]
    variants = [TradedVariant(name, "", "", name, "") for name in ("clamped", "bipods")]
    write_page(stored(compared("t", variants, [criterion], cells), tmp_path))
    text = (tmp_path / "trade.md").read_text(encoding="utf-8")
    assert "| noise | **3** (x) | **2** (x) | 0.667 | STRUT 8 to nothing, BIPOD nothing to 3 |" in text
    assert "| STRUT | 88.9 % | – |" in text
    assert "| OB | 11.1 % | 25.0 % |" in text


# --- its figure ---


@pytest.mark.parametrize(("variants", "criteria"), [(1, 1), (1, 8), (2, 3), (2, 8), (30, 8)])
def test_nothing_of_the_figure_is_cut_off_or_overlaps(variants: int, criteria: int) -> None:
    figure = drawn(parallel_figure(trade_of(variants, criteria)))
    width, height = (float(v) * figure.dpi for v in figure.get_size_inches())
    for said, box in texts(figure):
        assert min(box.x0, box.y0) >= 0, said
        assert box.x1 <= width, said
        assert box.y1 <= height, said
    assert overlaps(figure) == []


def lines_of(figure: Figure, name: str) -> list[np.ndarray]:
    return [
        np.asarray(line.get_ydata(), float) for a in figure.axes for line in a.get_lines() if line.get_label() == name
    ]


def test_better_is_higher_and_what_is_lacked_breaks_the_line() -> None:
    trade = trade_of(6)
    figure = parallel_figure(trade)
    shown = [c for c in range(7) if not np.isnan(trade.values[:, c]).all()]
    places = np.array([np.concatenate(lines_of(figure, v.name)) for v in trade.variants])
    assert places.shape == (6, len(shown))
    for place, c in enumerate(shown):
        of, at = trade.values[:, c], places[:, place]
        assert (np.isnan(of) == np.isnan(at)).all()
        order = np.argsort(of)
        sign = -1.0 if trade.criteria[c].goal == "min" else 1.0
        for i, j in pairwise(order[: np.count_nonzero(~np.isnan(of))]):
            assert sign * (at[j] - at[i]) >= 0.0
        if len(set(of[~np.isnan(of)])) > 1:
            assert np.nanmin(at) == pytest.approx(0.0)
            assert np.nanmax(at) == pytest.approx(1.0)


def test_small_differences_look_small_and_rounding_is_none() -> None:
    criterion = TradedCriterion("c", "mass", "w", "kg", "min", None, 0.0, "")
    scale = scale_of(criterion, np.array([200.0, 200.4, np.nan]))
    assert scale.at(200.0) - scale.at(200.4) == pytest.approx(0.1, rel=0.01)
    assert scale.at(200.2) == pytest.approx(0.5)
    chance = scale_of(replace(criterion, kind="probability"), np.array([0.997, 1.0]))
    assert chance.ends == pytest.approx([0.9885, 1.0]), "no probability is above 1"
    alike = scale_of(criterion, np.array([200.0, 200.0 * (1 + 1e-12)]))
    assert alike.ends == [200.0]
    assert alike.at(200.0) == 0.5
    wide = scale_of(criterion, np.array([1.0, 100.0]))
    assert wide.at(10.0) == pytest.approx(0.5), "logarithmic from a decade on"
    assert scale_of(criterion, np.array([0.0, 100.0])).at(50.0) == pytest.approx(0.5)
