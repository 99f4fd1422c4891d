"""The field at rest as sensitivity.h5 tells it: its verdicts, and the symbols and words they are shown with."""

from __future__ import annotations

from collections.abc import Sequence

from tedm_cli.files.store import Reader
from tedm_cli.gravity.requirements import MODELLED, DcVerdict
from tedm_cli.results.ranking import first_largest

#: What a subsystem is, in words.
SUBSYSTEM = {"IS": "IS: inertial sensor", "LTP": "LTP: the rest of it", MODELLED: f"{MODELLED}: both together"}


def dc_verdicts(file: Reader) -> list[DcVerdict]:
    """Verdicts on the field at rest in sensitivity.h5, in the order in which they were made."""
    names = [file.strings(f"/dc_verdict/{c}") for c in ("test_mass", "quantity", "subsystem")]
    numbers = [file.array(f"/dc_verdict/{c}").tolist() for c in ("value", "lower", "upper")]
    return [DcVerdict(*row) for row in zip(*names, *numbers, strict=True)]


def worst_at_rest(verdicts: Sequence[DcVerdict]) -> DcVerdict:
    """The verdict with the largest ratio."""
    return first_largest(verdicts, [v.ratio for v in verdicts])


def symbol(quantity: str) -> str:
    """A judged quantity as it is printed: `gamma_xx` as Γ_xx, `omegadot_eta` as ω̇_eta."""
    return quantity.replace("gamma", "Γ").replace("omegadot", "ω̇")
