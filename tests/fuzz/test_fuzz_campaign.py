"""A sample of the campaign of `make fuzz` over every kind of file: read right, or refused in one clear error.

`python tests/fuzz --seed 7 --count 10000` judges more of them, `--kind r.csv --first 0 --count 100` those of one kind.
"""

from __future__ import annotations

import io
import os
import signal
import time
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from random import Random

import fuzz_campaign
import pytest
from fuzz_campaign import FAMILIES, WEIGHTS, Counts, Judges, again, campaign, class_of, jobs, share
from fuzz_hdf5 import DAMAGE, EDITS, MUTATIONS
from fuzz_judge import KINDS, Judge, Verdict
from fuzz_users import ARCHIVES, READERS, Users, mutations_of
from fuzz_users_text import bomb

from tedm_cli.config import requirements
from tedm_cli.contracts import KINDS as CONTRACTS
from tedm_cli.errors import InputError
from tedm_cli.quantities import Quantity
from tedm_cli.tables.csv_table import Row

SEED, COUNT = 1, 50
RELIABILITY = Path(__file__).parents[2] / "docs" / "reference" / "reliability.md"


@pytest.fixture(scope="session")
def judges(judge: Judge, tmp_path_factory: pytest.TempPathFactory) -> Judges:
    made = Judges(tmp_path_factory.mktemp("campaign") / "judges")
    made.made["inputs"] = judge
    return made


def test_a_sample_is_read_right_or_refused_in_one_clear_error(judges: Judges) -> None:
    verdicts = [judges.judge(kind, number) for kind, number in jobs(SEED, COUNT)]
    assert not [str(v) for v in verdicts if v.failed]
    assert {v.kind for v in verdicts} == set(WEIGHTS)
    classes = Counter(class_of(v) for v in verdicts)
    assert classes["one error"] > COUNT // 2, "most mutations do damage"
    assert classes["same"] + classes["meaning"] > COUNT // 20, "not everything is refused"


@pytest.fixture(scope="module")
def between_stages(judges: Judges) -> list[Verdict]:
    """Two of every mutation of files between the stages, the files in turns."""
    files = list(FAMILIES["HDF5"])
    return [judges.judge(files[number % len(files)], number) for number in range(2 * len(MUTATIONS))]


def test_the_same_numbers_or_one_clear_error(between_stages: list[Verdict]) -> None:
    assert not [str(v) for v in between_stages if v.failed]
    assert {v.kind for v in between_stages} == set(FAMILIES["HDF5"])
    assert len(FAMILIES["HDF5"]) == len(CONTRACTS), "a file of every kind"


def test_damage_is_found_before_hdf5_sees_it(between_stages: list[Verdict]) -> None:
    facts = ("is damaged: its SHA-256", "carries no seal", "is no HDF5 file")
    for verdict in between_stages:
        if verdict.mutation in DAMAGE and verdict.outcome != "same":  # a block of zeros has been zeroed
            assert any(fact in verdict.detail for fact in facts), str(verdict)
        if verdict.mutation in EDITS and verdict.outcome != "same":
            assert not any(fact in verdict.detail for fact in facts), str(verdict)


@pytest.mark.parametrize("kind", [k for k in ARCHIVES if k not in ("controller.npz", "MODEL.TMD", "TIMES.TMD")])
def test_an_archive_that_takes_gigabytes_is_refused(judges: Judges, kind: str) -> None:
    number = list(mutations_of(kind)).index(bomb.__name__)
    verdict = judges.judge(kind, number)
    assert verdict.mutation == "bomb"
    assert verdict.outcome == "4", verdict
    assert "bytes" in verdict.detail


def test_every_mutation_changes_something(judges: Judges) -> None:
    users = judges.of("cases.toml")
    assert isinstance(users, Users)
    for kind in ("cases.toml", "r.npz", "optics.mat"):
        sound = users.path(kind).read_bytes()
        for name, mutate in mutations_of(kind).items():
            assert any(mutate(Random(n), sound) != sound for n in range(10)), (kind, name)


def test_a_reader_that_guesses_is_silent(judges: Judges, monkeypatch: pytest.MonkeyPatch) -> None:
    """The judge can fail: a table that cannot be read is taken for the one that it was."""
    sound = requirements.read_table(_users(judges).path("budget.csv"), requirements.COLUMNS)

    def guessing(path: Path, columns: Mapping[str, Quantity | None]) -> list[Row]:
        try:
            return original(path, columns)
        except InputError:
            return sound

    original = requirements.read_table
    monkeypatch.setattr(requirements, "read_table", guessing)
    number = list(mutations_of("budget.csv")).index("other_type")
    verdicts = [judges.judge("budget.csv", number + n * len(mutations_of("budget.csv"))) for n in range(4)]
    assert "SILENT" in {v.outcome for v in verdicts}


def _users(judges: Judges) -> Users:
    users = judges.of("budget.csv")
    assert isinstance(users, Users)
    return users


def test_a_share_for_every_kind_and_a_number_for_every_mutant() -> None:
    assert set(WEIGHTS) == {*KINDS, *READERS, *FAMILIES["HDF5"]}
    assert sum(share(10_000).values()) == 10_000
    assert min(share(10_000).values()) >= 40
    wanted = jobs(7, 10_000)
    assert len(set(wanted)) == len(wanted) == 10_000
    assert not set(wanted) & set(jobs(8, 10_000))
    assert {kind for kind, _ in wanted[:500]} == set(WEIGHTS), "any part of a campaign has some of each"


class Strange:
    """A judge of mutants by their number: one in four goes wrong in a way of its own."""

    def judge(self, kind: str, number: int) -> Verdict:
        if number % 4 == 1:
            os.kill(os.getpid(), signal.SIGKILL)
        if number % 4 == 2:
            signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGPROF, signal.SIGALRM})
            while True:
                time.sleep(0.0)
        return Verdict(kind, number, "none", "SILENT" if number % 4 == 3 else "same", "")


def test_a_mutant_that_kills_or_never_ends_is_counted_and_the_rest_goes_on(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(fuzz_campaign, "LIMIT", 0.3)
    monkeypatch.setattr(fuzz_campaign, "FAMILIES", {"decks": {"bdf": 1}})
    monkeypatch.setattr(fuzz_campaign, "jobs", lambda seed, count: [("bdf", n) for n in range(count)])
    monkeypatch.setattr(Judges, "of", lambda self, kind: Strange())
    out = io.StringIO()
    assert campaign(5, 8, 2, tmp_path / "log", out) == 6
    said = out.getvalue().splitlines()
    assert [line.split() for line in said if line.startswith("all")] == [
        ["all", "8", "2", "0", "0", "0", "2", "2", "0", "2", "0"]
    ]
    assert said[-1].startswith("seed 5: 8 mutants, 6 failed; ")
    log = (tmp_path / "log").read_text()
    assert [again("bdf", n) in log for n in range(8)] == [n % 4 > 0 for n in range(8)]


def test_what_is_no_failure_is_right_or_one_error() -> None:
    counts = Counts()
    for outcome in ("same", "rounding", "meaning", "exchanged", "InputError", "4", "refused 4", "SILENT", "MEMORY"):
        counts.add(Verdict("bdf", 0, "", outcome, ""))
    assert counts.failed == 2
    assert counts.by_kind["bdf"] == {"same": 2, "meaning": 1, "exchanged": 1, "one error": 3, "silent": 1, "other": 1}


def test_the_page_counts_the_campaign() -> None:
    """The table of 10,000 mutants, in the order of the families."""
    page, mutants = RELIABILITY.read_text(encoding="utf-8"), share(10_000)
    assert f"`make fuzz` judges 10,000 damaged files of {len(mutants)} kinds" in page
    rows = page.split("| files | of 10,000 |")[1].split("\n\n")[0].splitlines()[2:]
    counted = [int(row.split("|")[2].replace(",", "")) for row in rows]
    assert counted == [sum(mutants[kind] for kind in family) for family in FAMILIES.values()]
