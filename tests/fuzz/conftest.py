import sys
from pathlib import Path

import pytest

sys.path += [str(Path(__file__).parents[1] / name) for name in ("borders", "thermal")]

from fuzz_judge import Judge
from fuzz_model import Case, fuzz_case


@pytest.fixture(scope="session")
def sound(tmp_path_factory: pytest.TempPathFactory) -> Case:
    """The least model with its results. Not to be changed: copy it."""
    return fuzz_case(tmp_path_factory.mktemp("fuzz") / "fuzz")


@pytest.fixture(scope="session")
def judge(sound: Case) -> Judge:
    return Judge(sound)


@pytest.fixture
def case(sound: Case, tmp_path: Path) -> Case:
    """A copy that a test may change."""
    return sound.copy(tmp_path / "case")
