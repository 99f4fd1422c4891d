"""The field at rest for the report: by source and summed, its verdicts, and the stiffness of the test masses."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from tedm_cli.figures.data import SUPERSCRIPT, Array, first_largest
from tedm_cli.gravity.requirements import MODELLED
from tedm_cli.store import Reader

_ROUNDING = 1e-9  # entries this far below what they are compared with are shown as 0


def field_at_rest(file: Reader) -> dict[str, Any]:
    """What the report says of sensitivity.h5 apart from [S_SG]."""
    names, sources = file.strings("/test_mass/name"), file.strings("/source/name")
    a, w = file.array("/dc/acceleration"), file.array("/dc/angular_acceleration")
    error, points = file.array("/source/quadrature_error"), file.array("/source/points")
    rows: list[tuple[Any, ...]] = []
    for t, name in enumerate(names):
        for s, source in enumerate(sources):
            quadrature = {"points": int(points[t, s]), "error": None if math.isnan(error[t, s]) else error[t, s]}
            rows.append((name, source, _marked(a[t, s], a), _marked(w[t, s], w), quadrature))
        rows.append((name, "sum", _marked(a[t].sum(axis=0), a), _marked(w[t].sum(axis=0), w), None))
    return {
        "rows": rows,
        "sources": sources,
        "mass_model": file.string("/source/mass_model"),
        "position": list(zip(names, file.array("/test_mass/position"), file.array("/test_mass/mass"), strict=True)),
        "verdicts": _verdicts(file),
        "stiffness": [_stiffness(file, t, name, sources) for t, name in enumerate(names)],
        "linearised": _linearised(file),
    }


def _marked(values: Array, reference: Array) -> list[tuple[float, bool]]:
    """Values, and whether each is no more than rounding beside the largest of its kind."""
    largest = float(np.abs(reference).max())
    return [(float(v), bool(abs(v) < _ROUNDING * largest)) for v in values]


def _verdicts(file: Reader) -> dict[str, Any]:
    """Rows by test mass and quantity; how many pass, all of them and those on everything modelled; the worst."""
    names = ("test_mass", "quantity", "subsystem", "unit")
    numbers = ("value", "lower", "upper", "ratio", "passed")
    columns = [file.strings(f"/dc_verdict/{c}") for c in names] + [file.array(f"/dc_verdict/{c}") for c in numbers]
    rows = [dict(zip((*names, *numbers), row, strict=True)) for row in zip(*columns, strict=True)]
    by_mass: dict[str, dict[str, list[dict[str, Any]]]] = {}
    for row in rows:
        row["symbol"] = row["quantity"].replace("gamma", "Γ").replace("omegadot", "ω̇")
        row["allowed"] = _range_text(row["lower"], row["upper"])
        row["rounding"] = row["ratio"] < _ROUNDING
        by_mass.setdefault(row["test_mass"], {}).setdefault(row["quantity"], []).append(row)
    whole = [row for row in rows if row["subsystem"] == MODELLED]
    return {
        "by_mass": by_mass,
        "count": len(rows),
        "passed": sum(bool(row["passed"]) for row in rows),
        "whole_count": len(whole),
        "whole_passed": sum(bool(row["passed"]) for row in whole),
        "worst": first_largest(rows, [row["ratio"] for row in rows]),
    }


def _range_text(lower: float, upper: float) -> str:
    """A range with its power of ten once: ±3.5 × 10⁻¹⁰, (−1 to 2) × 10⁻⁷."""
    exponent = math.floor(math.log10(max(-lower, upper)) + _ROUNDING)
    low, high = (f"{end / 10.0**exponent:.4g}".replace("-", "−") for end in (lower, upper))
    ends = f"±{high}" if low == f"−{high}" else f"({low} to {high})"
    return f"{ends} × 10{str(exponent).translate(SUPERSCRIPT)}"


def _stiffness(file: Reader, t: int, name: str, sources: list[str]) -> dict[str, Any]:
    """The four stiffness matrices of one test mass: sums first, then by source."""
    matrices = []
    for key, symbol in (("gamma_lin", "Γ_lin"), ("omega_lin", "Ω_lin"), ("gamma_ang", "Γ_ang"), ("omega_ang", "Ω_ang")):
        path = f"/stiffness/{key}"
        value = file.array(path)[t]
        parts = [("sum", value.sum(axis=0)), *zip(sources, value, strict=True)]
        matrices.append(
            {
                "symbol": symbol,
                "unit": file.units(path),
                "meaning": file.kind.datasets[path].long_name,
                "parts": [(source, [_marked(row, matrix) for row in matrix]) for source, matrix in parts],
            }
        )
    return {"name": name, "sources": sources, "matrices": matrices}


def _linearised(file: Reader) -> dict[str, Any]:
    """The equations of motion of all test masses. Blocks of 3 × 3 share a unit and are judged for rounding alone."""
    value = file.array("/stiffness/linearised")
    largest = np.abs(value).reshape(len(value) // 3, 3, -1, 3).max(axis=(1, 3)).repeat(3, axis=0).repeat(3, axis=1)
    label = {c: file.strings(f"/label/{c}") for c in ("tm_output", "tm_output_unit", "tm_motion", "tm_motion_unit")}
    cells = [
        [(float(v), bool(abs(v) < _ROUNDING * m)) for v, m in zip(row, reference, strict=True)]
        for row, reference in zip(value, largest, strict=True)
    ]
    return {
        "columns": list(zip(label["tm_motion"], label["tm_motion_unit"], strict=True)),
        "rows": list(zip(label["tm_output"], label["tm_output_unit"], cells, strict=True)),
    }
