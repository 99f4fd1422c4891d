"""The samples that projects begin from, and where their files are.

`configs/` and `sample_models/` of the repository are the only copies; `setup.py` puts what is named here into a wheel,
beside this file. The standard library is all that is imported: an installation runs it before there is any other.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Script:
    """A script that makes the model of a sample from its layout, the files that it imports, and its arguments."""

    file: str
    model: str
    imported: tuple[str, ...] = ()
    arguments: tuple[str, ...] = ()


@dataclass(frozen=True)
class Sample:
    """A project to begin from.

    Parameters
    ----------
    files : sources, each with its own name in the project.
    script : what makes its model; None where the model is one of the files.
    """

    files: tuple[str, ...]
    script: Script | None = None

    @property
    def sources(self) -> tuple[str, ...]:
        made = () if self.script is None else (self.script.file, *self.script.imported)
        return (*self.files, *made)


PROJECT, LAYOUT = "tedm.toml", "optics.toml"
_LTP, _LISA, _SMALL, _MINIMAL = "configs", "configs/lisa_like", "sample_models/small", "sample_models/minimal"
_SPACECRAFT = "configs/spacecraft"
_SCRIPTS = "sample_models"
_SOLIDS = (f"{_SCRIPTS}/deck_cards.py", f"{_SCRIPTS}/ltp_like_solids.py")
_NETWORK = tuple(f"{_SCRIPTS}/ltp_like_{name}.py" for name in ("assumptions", "mounts", "network", "spacecraft"))

SAMPLES = {
    "minimal": Sample(
        (
            *(f"{_MINIMAL}/{name}" for name in (PROJECT, "cases.toml")),
            f"{_LTP}/{LAYOUT}",
            *(f"{_SMALL}/{name}" for name in ("model.toml", "ltp_small.bdf", "ltp_small_areas.csv")),
            *(f"{_SMALL}/{name}" for name in ("unit_loads.bdf", "unit_loads.op2")),
        )
    ),
    "ltp": Sample(
        tuple(
            f"{_LTP}/{name}"
            for name in (
                *(PROJECT, "model.toml", LAYOUT, "cases.toml", "dynamics.toml", "thermal.toml"),
                *("loads.toml", "balance.toml", "balance_parts.csv"),
            )
        ),
        Script(f"{_SCRIPTS}/ltp_like.py", "ltp.bdf", (*_SOLIDS, *_NETWORK)),
    ),
    "spacecraft": Sample(
        (
            *(f"{_SPACECRAFT}/{name}" for name in (PROJECT, "model.toml", "cases.toml")),
            *(f"{_LTP}/{name}" for name in (LAYOUT, "dynamics.toml")),
        ),
        Script(f"{_SCRIPTS}/ltp_like.py", "ltp_spacecraft.bdf", (*_SOLIDS, *_NETWORK), ("--spacecraft",)),
    ),
    "lisa": Sample(
        tuple(f"{_LISA}/{name}" for name in (PROJECT, "model.toml", LAYOUT, "cases.toml")),
        Script(f"{_SCRIPTS}/lisa_like.py", "lisa.bdf", (f"{_SCRIPTS}/lisa_like_layout.py", *_SOLIDS)),
    ),
}


def sources() -> tuple[str, ...]:
    """The files of all samples, relative to the root of the repository."""
    return tuple(dict.fromkeys(name for sample in SAMPLES.values() for name in sample.sources))


def root() -> Path:
    """The folder that `sources` are relative to: of an installation this one, else that of the repository."""
    here = Path(__file__).resolve().parent
    return here if (here / _LTP).is_dir() else here.parents[1]
