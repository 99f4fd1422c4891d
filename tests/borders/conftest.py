from pathlib import Path

import pytest
from border_tools import Project, build_chain, tiny_project
from mapped_project import BY_ELEMENT, ELEMENTS, K, with_map
from shared_folder import shared


@pytest.fixture(scope="session")
def chain(tmp_path_factory: pytest.TempPathFactory) -> Project:
    """The small sample with its whole chain built, case 3 included. Not to be changed: copy it."""
    return Project(shared(tmp_path_factory, "small", build_chain))


@pytest.fixture
def small(chain: Project, tmp_path: Path) -> Project:
    """A copy of the built chain that a test may change."""
    return chain.copy(tmp_path / "small")


@pytest.fixture(scope="session")
def bricks(tmp_path_factory: pytest.TempPathFactory) -> Project:
    """Two bricks, ingested. Not to be changed: copy it."""
    return tiny_project(tmp_path_factory.mktemp("bricks") / "tiny")


@pytest.fixture
def tiny(bricks: Project, tmp_path: Path) -> Project:
    """A copy of the two bricks that a test may change."""
    return bricks.copy(tmp_path / "tiny")


@pytest.fixture
def two(tiny: Project) -> Project:
    """Two bricks, a thermal node each."""
    return with_map(tiny, ELEMENTS + K, nodes=BY_ELEMENT, tau="set,LOW,HIGH\nup,0.25,1.5\neven,2,2\n")
