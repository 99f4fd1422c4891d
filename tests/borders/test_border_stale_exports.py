"""What goes out to other programs is made from the configuration and the results that are there now."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from border_tools import Project, replace, tedm, untouched

EXPORTS = {
    "optics": ("export", "optics"),
    "sensitivity": ("export", "sensitivity"),
    "distortion": ("export", "distortion"),
    "case": ("export-case", "3"),
    "extremal": ("export-extremal", "3"),
}
#: a configuration, the exports of files that were made with it, and how they are made again
CHANGES = [
    ("cases.toml", {"case", "extremal"}, "tedm run-case 3"),
    ("optics.toml", {"optics", "distortion"}, "tedm build-"),
    ("model.toml", {"sensitivity"}, "tedm build-"),
]


@pytest.mark.parametrize(("name", "stale", "hint"), CHANGES, ids=[c[0] for c in CHANGES])
@pytest.mark.parametrize("kind", EXPORTS)
def test_a_changed_configuration(small: Project, name: str, stale: set[str], hint: str, kind: str) -> None:
    path = small.folder / name
    path.write_text(path.read_text() + "# one comment more\n")
    if kind not in stale:
        tedm(*EXPORTS[kind], "-d", small.build).ok()
        return
    with untouched(small.folder):
        tedm(*EXPORTS[kind], "-d", small.build).refused(4, "is stale", f"{name} as it is now", hint=hint)


@pytest.mark.parametrize("command", [("run-case", "3"), ("run-case", "all"), ("export-state-space", "3")])
@pytest.mark.parametrize(("name", "hint"), [("model.toml", "build-sensitivity"), ("optics.toml", "build-optics")])
def test_cases_of_another_configuration(small: Project, name: str, hint: str, command: tuple[str, ...]) -> None:
    """As when two projects share a build folder, or a test mass was moved and only the case run again."""
    (small.folder / name).write_text((small.folder / name).read_text() + "# one comment more\n")
    with untouched(small.folder):
        small.run(*command).refused(4, "is stale", f"{name} as it is now", hint=f"rebuild it with `tedm {hint}`")
    (small.folder / name).unlink()  # without its layout the project is one of self-gravity alone
    with untouched(small.folder):
        if name == "model.toml":
            small.run(*command).refused(4, "model.toml: cannot read the configuration")
        elif command[0] == "run-case":
            small.run(*command).refused(3, "requirement[1]: lpf_readout_item judges read-outs")
        else:
            small.run(*command).refused(4, "case03.h5: is stale: made from optics.h5, which is no part of the project")


@pytest.mark.parametrize("kind", ["optics", "sensitivity", "case", "extremal"])
def test_results_that_were_made_anew(small: Project, kind: str) -> None:
    replace(small.model, "mid_half_width_m = 0.005", "mid_half_width_m = 0.006")
    small.stage("ingest").ok()
    small.stage("build-distortion").ok()
    with untouched(small.folder):
        tedm(*EXPORTS[kind], "-d", small.build).refused(4, "is stale", "as it is now", hint="rebuild it with")
    tedm("export", "distortion", "-d", small.build).ok()


@pytest.mark.parametrize("kind", EXPORTS)
def test_a_build_folder_by_itself(small: Project, tmp_path: Path, kind: str) -> None:
    """What is gone proves nothing: results can be exported where their sources are not."""
    alone = tmp_path / "elsewhere" / "build"
    shutil.copytree(small.build, alone)
    tedm(*EXPORTS[kind], "-d", alone).ok()
