"""Damaged and edited files between the stages give the same numbers or one clear error, and never hang."""

from __future__ import annotations

from collections import Counter

import pytest
from fuzz_hdf5 import DAMAGE, EDITS, MUTATIONS
from fuzz_hdf5_judge import NEXT, Hdf5Judge, Verdict

FIRST, COUNT = 0, 3 * len(MUTATIONS)


@pytest.fixture(scope="module")
def verdicts(tmp_path_factory: pytest.TempPathFactory) -> list[Verdict]:
    judge = Hdf5Judge(tmp_path_factory.mktemp("hdf5") / "chain")
    return [judge.judge(number) for number in range(FIRST, FIRST + COUNT)]


def test_the_same_numbers_or_one_clear_error(verdicts: list[Verdict]) -> None:
    assert not [str(v) for v in verdicts if v.failed]
    assert {v.file for v in verdicts} == set(NEXT)
    outcomes = Counter(v.outcome for v in verdicts)
    assert outcomes["refused 4"] > COUNT // 2, "most mutations do damage"
    assert outcomes["same"] > 0, "not everything is refused"


def test_damage_is_found_before_hdf5_sees_it(verdicts: list[Verdict]) -> None:
    facts = ("is damaged: its SHA-256", "carries no seal", "is no HDF5 file")
    for verdict in verdicts:
        if verdict.mutation in DAMAGE and verdict.outcome != "same":  # a block of zeros has been zeroed
            assert any(fact in verdict.detail for fact in facts), str(verdict)
        if verdict.mutation in EDITS and verdict.outcome != "same":
            assert not any(fact in verdict.detail for fact in facts), str(verdict)
