"""Mutated decks and results are read right or refused in one line: `python tests/fuzz` judges any number of them."""

from __future__ import annotations

import contextlib
import io
import sys
from collections import Counter
from unittest import mock

import pytest
from fuzz_binary import BINARY
from fuzz_judge import Judge, mutant
from fuzz_model import Case
from fuzz_msc_hdf5 import MSC_HDF5
from fuzz_structure import STRUCTURE
from fuzz_text import TEXT

from tedm_cli.cli import main

BATCH = 60
BATCHES = [
    (kind, BATCH * i)
    for kind, count in (("op2", 240), ("bdf", 240), ("structure", 60), ("solver", 60))
    for i in range(count // BATCH)
]


@pytest.mark.parametrize(("kind", "first"), BATCHES, ids=[f"{kind}-{first}" for kind, first in BATCHES])
def test_a_mutated_input_is_read_right_or_refused(judge: Judge, kind: str, first: int) -> None:
    verdicts = [judge.judge(kind, number) for number in range(first, first + BATCH)]
    assert not [str(v) for v in verdicts if v.failed]
    outcomes = Counter(v.outcome for v in verdicts)
    assert outcomes["InputError"] > BATCH // 4, "most mutations do damage"
    assert outcomes["same"] + outcomes["meaning"] > 0, "not everything is refused"


def test_one_of_every_mutation_of_hdf5(judge: Judge) -> None:
    """Each is first read by a process of its own, so these are few."""
    verdicts = [judge.judge("msc.h5", number) for number in range(len(MSC_HDF5))]
    assert not [str(v) for v in verdicts if v.failed]
    outcomes = Counter(v.outcome for v in verdicts)
    assert outcomes["InputError"] > len(MSC_HDF5) // 4
    assert outcomes["same"] + outcomes["rounding"] > 0


def test_every_mutation_changes_the_file(judge: Judge) -> None:
    for kind, table in (("bdf", TEXT), ("op2", BINARY), ("msc.h5", MSC_HDF5), ("structure", STRUCTURE)):
        unchanged = Counter[str]()
        for number in range(20 * len(table)):
            name, data = mutant(kind, number, judge.sound[kind])
            unchanged[name] += data == judge.sound[kind]
            assert mutant(kind, number, judge.sound[kind]) == (name, data), "a number is one mutation"
        assert max(unchanged.values()) < 20


@pytest.mark.parametrize("first", range(0, 40, 20))
@pytest.mark.parametrize("kind", ["bdf", "op2"])
def test_the_command_says_one_line_and_keeps_the_old_file(case: Case, kind: str, first: int) -> None:
    """Exit codes 3 to 5 with one error and at most one hint; what was in the build folder is as it was."""
    file = {"bdf": case.deck, "op2": case.op2}[kind]
    sound = file.read_bytes()
    refused = 0
    for number in range(first, first + 20):
        name, data = mutant(kind, number + 100_000, sound)
        file.write_bytes(data)
        before = {p.name: p.read_bytes() for p in case.unit_loads.parent.iterdir()}
        out, err = io.StringIO(), io.StringIO()
        argv = ["tedm", "ingest", "-c", str(case.folder / "tedm.toml"), "-d", str(case.unit_loads.parent)]
        with (
            mock.patch.object(sys, "argv", argv),
            contextlib.redirect_stdout(out),
            contextlib.redirect_stderr(err),
            pytest.raises(SystemExit) as left,
        ):
            main()
        after = {p.name: p.read_bytes() for p in case.unit_loads.parent.iterdir()}
        what = f"{kind} {number + 100_000} ({name}): {err.getvalue()}"
        assert left.value.code in (None, 0, 4, 5), what
        if left.value.code:
            refused += 1
            lines = err.getvalue().splitlines()
            assert [line.split(":")[0] for line in lines] in (["error"], ["error", "hint"]), what
            assert "pyNastran_crash" not in what
            assert after == before, what
        else:
            assert not err.getvalue(), what
            assert after.keys() == before.keys(), what
    assert refused > 4
