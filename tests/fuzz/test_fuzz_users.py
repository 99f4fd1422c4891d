"""What users write, damaged: an answer, or one clear error; `python tests/fuzz --kind users` judges any number."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from random import Random

import pytest
from fuzz_users import ARCHIVES, READERS, Users, mutations_of
from fuzz_users_text import bomb

FIRST, COUNT = 10_000, 4


@pytest.fixture(scope="session")
def users(tmp_path_factory: pytest.TempPathFactory) -> Users:
    return Users(tmp_path_factory.mktemp("users"))


@pytest.mark.parametrize("kind", READERS)
def test_damage_is_refused_in_one_clear_error_or_harmless(users: Users, kind: str) -> None:
    verdicts = [users.judge(kind, number) for number in range(FIRST, FIRST + COUNT)]
    assert not [str(v) for v in verdicts if v.failed]
    assert Counter(v.outcome.isdigit() for v in verdicts)[True], "some damage is refused"


@pytest.mark.parametrize("kind", ARCHIVES)
def test_an_archive_that_takes_gigabytes_is_refused(users: Users, kind: str) -> None:
    number = list(mutations_of(kind)).index(bomb.__name__)
    verdict = users.judge(kind, number)
    assert verdict.mutation == "bomb"
    assert verdict.outcome == "4", verdict
    assert "bytes" in verdict.detail


def test_every_mutation_changes_something(users: Users) -> None:
    for kind in ("cases.toml", "r.npz", "optics.mat"):
        sound = Path(users.folder / READERS[kind][0]).read_bytes()
        for name, mutate in mutations_of(kind).items():
            assert any(mutate(Random(n), sound) != sound for n in range(10)), (kind, name)
