"""The page of large models shows the stored results, and what measures them works on toys."""

from __future__ import annotations

import mmap
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks import __main__ as command
from benchmarks import goals, growth, page, process, ratios, record, scale
from benchmarks.gravity import _shared_corners
from benchmarks.plots import FIGURES, exponents
from benchmarks.record import About, Record
from benchmarks.tables import TABLES, number
from benchmarks.timing import Times, timed

TOY = (6, 4, 3)
ABOUT = About("abc1234", "2026-01-01", "2026-01-02", "2 × processor, 8 GB", "Python", 0.5)


def test_tables_of_the_page_are_the_stored_results() -> None:
    text = page.PAGE.read_text(encoding="utf-8")
    records = record.stored()
    assert page.filled(text, records) == text, "run python -m benchmarks.page"
    for table in TABLES:
        started = "| " if table.of in records else "*Not measured: "
        assert f"<!-- benchmark {table.name} -->\n{started}" in text


def test_a_changed_result_changes_the_page_and_a_table_without_a_place_is_told() -> None:
    text, records = page.PAGE.read_text(encoding="utf-8"), record.stored()
    old = records["chunks"]
    records["chunks"] = Record("chunks", ABOUT, [{**row, "write": 123.0} for row in old.rows])
    new = page.filled(text, records)
    assert new.count("| 123 |") == len(old.rows)
    assert "at commit abc1234 of 2026-01-01" in new
    del records["chunks"]
    assert "*Not measured: `python -m benchmarks chunks`.*" in page.filled(text, records)
    with pytest.raises(LookupError, match="no place for chunks"):
        page.filled(text.replace("<!-- benchmark chunks -->", ""), records)


def test_figures_of_the_page_have_the_stored_exponents() -> None:
    records, text = record.stored(), page.PAGE.read_text(encoding="utf-8")
    for name, (of, _) in FIGURES.items():
        assert f"(../images/{name})" in text
        drawn = (page.IMAGES / name).read_text(encoding="utf-8")
        for task in growth.tasks_of(records[of].rows):
            assert f">{task}: {exponents(records[of], task, of)}<" in drawn


def test_results_are_read_as_they_were_written(tmp_path: Path) -> None:
    rows = [{"stage": "α", "processor_s": 0.25, "chunk": None}, {"stage": "β", "processor_s": 1e-9, "chunk": [1, 2]}]
    assert record.read(Record("one", ABOUT, rows).write(tmp_path)) == Record("one", ABOUT, rows)
    assert list(record.stored(tmp_path)) == ["one"]


def test_a_process_is_measured_with_those_it_starts(tmp_path: Path) -> None:
    work = "import time\nend = time.process_time() + 0.3\nwhile time.process_time() < end: pass\n"
    held = "x = bytearray(60_000_000)\nfor i in range(0, len(x), 4096): x[i] = 1\nimport time; time.sleep(0.1)\n"
    started = f"subprocess.run([sys.executable, '-c', {work + held!r}], check=True)"
    found = process.run(["-c", f"import subprocess, sys\n{started}\nprint('done')\n"], folder=tmp_path)
    assert found.output == "done\n"
    assert found.processor_s > 0.3
    assert 60.0 < found.anonymous_mb < 120.0
    assert found.resident_mb > found.anonymous_mb


def test_mapped_pages_are_not_anonymous(tmp_path: Path) -> None:
    path = tmp_path / "mapped"
    path.write_bytes(b"1" * 60_000_000)
    code = (
        f"import mmap, time\nwith open({str(path)!r}, 'rb') as f:\n"
        " m = mmap.mmap(f.fileno(), 0, access=mmap.ACCESS_READ)\n"
        f" sum(m[i] for i in range(0, len(m), {mmap.PAGESIZE}))\n time.sleep(0.1)\n"
    )
    found = process.run(["-c", code])
    assert found.file_mb > 60.0
    assert found.anonymous_mb < 30.0


def test_a_copy_that_shares_the_memory_of_another_is_not_counted() -> None:
    code = "import os, time\nx = bytearray(b'1') * 50_000_000\n"
    code += "if os.fork():\n os.wait()\nelse:\n time.sleep(0.1)\n"
    assert 50.0 < process.run(["-c", code]).resident_mb < 90.0


def test_a_failure_of_a_process_is_told(capfd: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(process.subprocess.CalledProcessError):
        process.run(["-c", "raise SystemExit('what was wrong')"])
    assert "what was wrong" in capfd.readouterr().err


def test_growth_finds_powers_and_lines() -> None:
    sizes = [1.0, 10.0, 100.0]
    assert growth.exponent(sizes, [3.0 * n**1.5 for n in sizes]) == pytest.approx(1.5)
    assert growth.per_size(sizes, [7.0 + 2.0 * n for n in sizes]) == pytest.approx(2.0)


def test_timed_takes_turns_and_the_ratio_is_of_the_best() -> None:
    turns: list[str] = []
    found = timed(lambda: turns.append("work"), lambda: turns.append("peer"), runs=3, each=(4, "point"))
    assert turns == ["work", "peer"] * 4
    assert len(found.ours.processor) == 3
    assert found.each_s == found.ours.best / 4
    two = Times((3.0, 1.0, 2.0), (5.0, 6.0, 7.0))
    assert (two.best, two.median) == (1.0, 2.0)


def test_corner_kernels_each_once_give_force_and_gradient() -> None:
    from scipy.constants import gravitational_constant

    from tedm_cli.gravity.kernel import cuboid_force_gradient

    sides = np.array([0.046, 0.05, 0.03])
    points = np.random.default_rng(2).normal(size=(6, 3)) * 0.1 + 0.05
    nine = np.empty((6, 9))
    loop: Any = _shared_corners()
    loop.py_func(points, *(s * side / 2 for side in sides for s in (-1, 1)), nine)
    force, gamma = cuboid_force_gradient(points, sides)
    volume = sides.prod() * gravitational_constant
    np.testing.assert_allclose(-nine[:, :3] / volume, force, rtol=1e-9)
    order = [0, 3, 4, 3, 1, 5, 4, 5, 2]
    np.testing.assert_allclose(nine[:, 3:][:, order].reshape(-1, 3, 3) / volume, gamma, rtol=1e-8, atol=1e-12)


def test_op2_and_its_peers_on_a_toy(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(scale, "RUNS", 1)
    rows = list(growth.of_op2(3, TOY))
    assert [row["task"] for row in rows if row["task"] == row["stage"]] == list(growth.OP2)
    assert len(rows) == 7
    for row in rows:
        assert row["grids"] == 140
        assert row["areas"] == 3
        assert 0.0 < row["processor_s"] < 20.0
        assert 20.0 < row["anonymous_mb"] < row["resident_mb"]
    table = next(t for t in TABLES if t.name == "op2").markdown(Record("op2", ABOUT, rows))
    assert table.count("\n| ") == 8
    assert "| 1.0 |" in table


def test_goals_of_two_trees_are_measured_in_turn(monkeypatch: pytest.MonkeyPatch) -> None:
    turns: list[Path] = []

    def group(tree: Path, folder: Path) -> Iterator[goals.Found]:
        turns.append(tree)
        yield goals.Found("a goal", 1.0, "s", 2.0 if tree == goals.ROOT else 4.0, 1.0 if tree == goals.ROOT else 3.0)
        if tree != goals.ROOT:
            raise process.subprocess.CalledProcessError(1, ["what the older tree does not know"])
        yield goals.Found("another", 5.0, "ns", 6.0)

    monkeypatch.setattr(goals, "GROUPS", (group, group))
    monkeypatch.setattr(goals, "older", lambda commit, folder: folder)
    rows = list(goals.rows("abc1234"))
    assert turns[::2] == [goals.ROOT, goals.ROOT]
    assert goals.ROOT not in turns[1::2]
    table = next(t for t in TABLES if t.name == "goals").markdown(Record("goals", ABOUT, rows))
    assert "| commit abc1234 | now |" in table
    assert "| a goal | 1.0 s | 4.0 (3.0 processor s) | 2.0 (1.0 processor s) | 0.33 |" in table
    assert "| another | 5.0 ns |  | 6.0 |  |" in table


def test_every_set_has_a_command_and_every_table_a_set(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert {table.of for table in TABLES} == set(command.sets())
    stored = record.stored()
    assert {"op2", "grids", "areas", "decks", "chunks", "goals", "ratios"} <= set(stored) <= set(command.sets())
    row = ratios.of(timed(lambda: sum(range(99)), None, "a note", runs=1, each=(99, "point")))
    monkeypatch.setattr(ratios, "in_one_process", lambda: [{"work": "a sum", "peer": None, **row}])
    command.main(["ratios", "--into", str(tmp_path)])
    assert record.read(tmp_path / "ratios.json").rows == [{"work": "a sum", "peer": None, **row}]
    assert re.search(r"\| a sum \|  \| [0-9.,]+ [nµm]?s a point \|  \|  \| a note \|", capsys.readouterr().out)
    with pytest.raises(SystemExit):
        command.main(["nothing"])


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.0, "0"), (None, ""), (12345.6, "12,346"), (9.96, "10"), (9.94, "9.9"), (0.99, "0.99"), (0.0123, "0.012")],
)
def test_numbers_have_the_figures_that_they_need(value: float | None, text: str) -> None:
    assert number(value) == text


def test_headings_of_the_stored_results_have_no_paths() -> None:
    for found in record.stored().values():
        assert re.fullmatch(r"[0-9a-f]{7,}\+?", found.about.commit)
        assert "/" not in found.about.machine + found.about.libraries
