"""show: what a file holds and what it was made from."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tedm_cli.files.store import Reader, kind_of, open_checked


def show_dict(path: Path) -> dict[str, Any]:
    """Kind, versions, provenance, datasets and main numbers of a file."""
    kind = kind_of(path)
    with open_checked(path, kind) as file:
        provenance = file.provenance()
        return {
            "file": str(path),
            "kind": kind.name,
            "made_by": kind.made_by,
            "attributes": file.attributes,
            "configurations": [{"path": str(c.path), "sha256": c.sha256} for c in provenance.configs],
            "inputs": [{"path": str(i.path), "sha256": i.sha256} for i in provenance.inputs],
            "datasets": [
                {"path": p, "shape": list(shape), "units": unit, "long_name": name}
                for p, shape, unit, name in file.table()
            ],
            "main": _main_numbers(file),
        }


def _main_numbers(file: Reader) -> dict[str, Any]:
    """The few numbers a person opens each kind of file for."""
    if file.kind.name == "unit_loads":
        return {"mass_kg": file.number("/mass/total"), "areas": len(file.strings("/area/name"))}
    if file.kind.name == "distortion":
        residual = "/check/superposition_translation"
        return {"superposition_residual": file.number(residual) if file.has(residual) else None}
    if file.kind.name == "sensitivity":
        total = file.array("/dc/acceleration").sum(axis=1)
        return {
            f"{name}_a_m_s2": [float(v) for v in a]
            for name, a in zip(file.strings("/test_mass/name"), total, strict=True)
        }
    if file.kind.name == "optics":
        sets = zip(file.strings("/set/name"), file.array("/set/condition"), strict=True)
        return {"rank": int(file.number("/rank")), **{f"condition_{n}": float(c) for n, c in sets}}
    verdicts = zip(
        file.strings("/verdict/output"),
        file.strings("/verdict/requirement"),
        file.array("/verdict/ratio"),
        file.array("/verdict/passed"),
        strict=True,
    )
    return {f"{o} {q}": f"ratio {r:.4g}, {'pass' if p else 'FAIL'}" for o, q, r, p in verdicts}
