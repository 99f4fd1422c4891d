"""Faults from outside, a sample: `make faults` tries them at their full number, `make all` killed among them."""

from __future__ import annotations

from pathlib import Path
from unittest import mock

import faults
import pytest
from faults import COMMANDS, Chain, at_once, fill, in_process, kill

from tedm_cli.files import store

# Writers of HDF5 have tests of their own, killed when half of a file is there (tests/borders/test_border_kills.py).
SHORT = ("write-deck", "solve", "run-case 3", "run-series warm", "export --format npz", "export-vtu")
SHARES = (0.35, 0.6, 0.85)


@pytest.fixture(scope="module")
def chain(tmp_path_factory: pytest.TempPathFactory) -> Chain:
    return Chain(tmp_path_factory.mktemp("faults") / "small", SHORT)


@pytest.mark.parametrize("command", SHORT)
def test_a_killed_command_leaves_whole_files(chain: Chain, command: str) -> None:
    n = SHORT.index(command)
    assert kill(chain, command, SHARES[n % 3], had_files=n % 2 == 0) == ""


@pytest.mark.parametrize("command", SHORT)
def test_a_full_disk_is_one_error_and_changes_nothing(chain: Chain, command: str) -> None:
    assert fill(chain, command, 0.5) == ""


@pytest.mark.parametrize("share", [0.02, 0.999])
def test_what_a_series_keeps_on_disk_meanwhile_is_told_of_its_result(chain: Chain, share: float) -> None:
    """Samples wait in a nameless file beside it; the table that they come from is not to blame."""
    assert fill(chain, "run-series warm", share) == ""


def test_chains_at_once_in_one_folder(chain: Chain) -> None:
    assert at_once(chain, 2, ("run-case 3", "run-series warm", "export --format npz")) == ""


def test_half_a_file_is_noticed(chain: Chain) -> None:
    """The tests can fail: a command that writes straight into its file."""
    target = chain.folder / chain.targets["run-case 3"][0]
    sound = target.read_bytes()
    target.write_bytes(sound[:-1])
    assert "half build/case03.h5" in kill(chain, "export-vtu", 0.5, had_files=True)
    target.write_bytes(sound)
    assert kill(chain, "export-vtu", 0.5, had_files=True) == ""


def test_what_a_command_says_and_how_it_ends(chain: Chain) -> None:
    assert chain.run("run-case 99").code == 2
    assert "99" in chain.run("run-case 99").said
    with mock.patch.object(store, "create", side_effect=SystemExit(3)):
        assert in_process(lambda: store.create(Path(), None, None)).code == 3  # type: ignore[arg-type]
    assert set(SHORT) < set(COMMANDS)
    assert len(COMMANDS) == 25
    assert len(faults.SIZES) == 3
