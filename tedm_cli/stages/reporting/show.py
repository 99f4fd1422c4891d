"""show: what a file holds and what it was made from. What reads a kind of file is imported for that kind alone."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from tedm_cli.contracts import (
    ADJOINT,
    BALANCE,
    CASE,
    DISTORTION,
    DYNAMICS,
    LOADS,
    OPTICS,
    RELEASE,
    SENSITIVITY,
    TEMPERATURES,
    THERMAL,
    TRADE,
    UNIT_LOADS,
)
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
            **_judgement(file),
            "attributes": file.attributes,
            "configurations": [{"path": str(c.path), "sha256": c.sha256} for c in provenance.configs],
            "inputs": [{"path": str(i.path), "sha256": i.sha256} for i in provenance.inputs],
            "datasets": [
                {"path": p, "shape": list(shape), "units": unit, "long_name": name}
                for p, shape, unit, name in file.table()
            ],
            "main": _main_numbers(file),
            **({"materials": _materials(file)} if kind is ADJOINT else {}),
            **({"uncertainty": _uncertainty(file)} if kind is CASE else {}),
        }


def _judgement(file: Reader) -> dict[str, Any]:
    """The verdicts in a file, worst first, and whether all are passed; None of a kind of file that has no verdicts."""
    if file.kind is SENSITIVITY:
        from tedm_cli.results.gravity.field import dc_verdicts

        verdicts: list[dict[str, Any]] = [
            {
                "output": f"{v.place} {v.quantity}, {v.subsystem}",
                "requirement": v.requirement,
                "ratio": v.ratio,
                "passed": v.passed,
            }
            for v in dc_verdicts(file)
        ]
    elif file.kind is BALANCE:
        from tedm_cli.results.gravity.balance import read_balance

        found = read_balance(file)
        verdicts = [
            {
                "output": f"{v.place} {v.quantity}, {v.subsystem}",
                "requirement": v.requirement,
                "ratio": v.ratio,
                "passed": v.passed,
            }
            for v in found.after
        ]
    elif file.has(CASE.VERDICT_OUTPUT):
        columns = (CASE.VERDICT_RATIO, CASE.VERDICT_PASSED)
        numbers = zip(*(file.array(column).tolist() for column in columns), strict=True)
        names = zip(file.strings(CASE.VERDICT_OUTPUT), file.strings(CASE.VERDICT_REQUIREMENT), strict=True)
        verdicts = [
            {"output": output, "requirement": requirement, "ratio": ratio, "passed": bool(passed)}
            for (output, requirement), (ratio, passed) in zip(names, numbers, strict=True)
        ]
    else:
        return {"passed": None, "verdicts": None}
    verdicts.sort(key=lambda v: -v["ratio"])
    return {"passed": all(v["passed"] for v in verdicts) if verdicts else None, "verdicts": verdicts}


def _main_numbers(file: Reader) -> dict[str, Any]:
    """The few numbers a person opens each kind of file for, or its verdicts."""
    if file.kind.name == "unit_loads":
        return {"mass_kg": file.number(UNIT_LOADS.MASS_TOTAL), "areas": len(file.strings(CASE.AREA_NAME))}
    if file.kind.name == "distortion":
        residual = DISTORTION.CHECK_SUPERPOSITION_TRANSLATION
        return {"superposition_residual": file.number(residual) if file.has(residual) else None}
    if file.kind.name == "sensitivity":
        total = file.array(SENSITIVITY.DC_ACCELERATION).sum(axis=1)
        return {
            f"{name}_a_m_s2": [float(v) for v in a]
            for name, a in zip(file.strings(SENSITIVITY.TEST_MASS_NAME), total, strict=True)
        }
    if file.kind.name == "optics":
        sets = zip(file.strings(OPTICS.SET_NAME), file.array(OPTICS.SET_CONDITION), strict=True)
        return {"rank": int(file.number(OPTICS.RANK)), **{f"condition_{n}": float(c) for n, c in sets}}
    if file.kind.name == "adjoint":
        return _adjoint(file)
    if file.kind.name == "dynamics":
        return _loop(file)
    if file.kind.name == "figure_6_2":
        from tedm_cli.results.dynamics.imposed import read_imposed

        return {f"{n.test_mass}, {n.model}": f"{n.asd[0]:.4e} m/s^2/sqrt(Hz)" for n in read_imposed(file).noises}
    if file.kind.name == "release":
        numbers = zip(*(file.array(d).tolist() for d in (RELEASE.OUTPUT_PEAK, RELEASE.OUTPUT_SETTLED)), strict=True)
        labels, units = file.strings(RELEASE.OUTPUT_LABEL), file.strings(RELEASE.OUTPUT_UNIT)
        return {
            label: f"peak {peak:.4g} {unit}, " + (f"small after {s:.6g} s" if np.isfinite(s) else "large at the end")
            for label, unit, (peak, s) in zip(labels, units, numbers, strict=True)
        }
    if file.kind is BALANCE:
        return _balance(file)
    if file.kind is LOADS:
        return _loads(file)
    if file.kind is THERMAL:
        return _thermal(file)
    if file.kind is TRADE:
        return _trade(file)
    if file.kind is TEMPERATURES:
        sets = zip(file.strings(TEMPERATURES.SET_NAME), file.array(TEMPERATURES.TEMPERATURE), strict=True)
        return {name: f"{field.min():.6g} to {field.max():.6g} K" for name, field in sets}
    found = _judgement(file)["verdicts"] or []
    return {
        f"{v['output']} {v['requirement']}": f"ratio {v['ratio']:.4g}, {'pass' if v['passed'] else 'FAIL'}"
        for v in found
    }


def _adjoint(file: Reader) -> dict[str, Any]:
    """How far its sums are from the unit loads; or why there is none."""
    from tedm_cli.results.adjoint.file import read_adjoint

    found = read_adjoint(file)
    if isinstance(found, str):
        return {"no_adjoint": found}
    return {
        "outputs": len(found.label),
        "largest_difference": float(found.difference.max()),
        "largest_over_allowed": float((found.difference / found.allowed).max()),
    }


def _balance(file: Reader) -> dict[str, Any]:
    """The mass of the blocks, by box, and what became of drawn builds."""
    from tedm_cli.results.gravity.balance import read_balance

    found = read_balance(file)
    main: dict[str, Any] = {
        "met": f"{found.met} of {len(found.after)}, without the blocks {sum(v.passed for v in found.before)}",
        "mass_kg": found.total_kg,
        "relaxed_mass_kg": found.total_relaxed_kg,
        **{f"mass_kg {box}": float(mass) for box, (mass, _, _) in found.by_box().items()},
    }
    if (drawn := found.drawn) is not None:
        main["yield"] = f"{drawn.met} of {drawn.draws} builds, 95 % interval {drawn.low:.4g} to {drawn.high:.4g}"
    return main


def _loads(file: Reader) -> dict[str, Any]:
    """How much each load distorts, and the first frequency."""
    from tedm_cli.results.loads import read_loads

    found = read_loads(file)
    what = "the structure" if found.bench is None else "the benches"
    main: dict[str, Any] = {
        name: f"distorts {what} by {distortion:.4g} m" + ("" if unit == "1" else f" per {unit}")
        for name, unit, distortion in zip(found.name, found.unit, found.ranked, strict=True)
    }
    if found.modes is not None and len(found.modes.frequency_hz):
        main["first_frequency_Hz"] = float(found.modes.frequency_hz[0])
    return main


def _thermal(file: Reader) -> dict[str, Any]:
    """The steady state of the network, what low-pass each disturbance goes through, and what of it is on the model."""
    from tedm_cli.results.thermal.file import read_thermal

    found = read_thermal(file)
    main: dict[str, Any] = {}
    if (steady := found.steady) is not None:
        main |= {
            "nodes": sum(steady.count.values()),
            "coldest": f"{steady.coldest[0]}, {steady.coldest[1]:.6g} K",
            "hottest": f"{steady.hottest[0]}, {steady.hottest[1]:.6g} K",
            "largest_imbalance_W": steady.imbalance_W,
        }
    for d in found.disturbances:
        node, gain = d.largest[0]
        fit = "no low-pass fits" if d.order is None or d.corner_hz is None else (
            f"order {d.order.median:.3g}, corner {1e3 * d.corner_hz.median:.3g} mHz"
        )  # fmt: skip
        main[f"disturbance {d.name}"] = f"{d.spectrum}; largest gain {gain:.3g} at {node}; {fit}"
    return main | ({"nodes_on_the_model": len(found.mapped)} if found.mapped else {})


def _trade(file: Reader) -> dict[str, Any]:
    """Where each variant stands, and its values."""
    from tedm_cli.results.trade import read_trade

    found = read_trade(file)
    main: dict[str, Any] = {"pareto_front": ", ".join(found.front) or "no variant can be compared"}
    for variant, cells in zip(found.variants, found.cells, strict=True):
        values = [
            f"{criterion.name} {criterion.with_unit(cell.value)}{' FAIL' if cell.passed is False else ''}"
            for criterion, cell in zip(found.criteria, cells, strict=True)
            if cell.value is not None
        ]
        front = f"front {variant.front}: " if variant.front else ""
        main[f"variant {variant.name}"] = f"failed: {variant.failure}" if variant.failure else front + "; ".join(values)
    return main


def _uncertainty(file: Reader) -> Any:
    """How sure the verdicts of a case are, where it was asked."""
    from tedm_cli.results.cases.uncertainty import as_dict, read_uncertainty

    return as_dict(read_uncertainty(file))


def _materials(file: Reader) -> list[dict[str, Any]]:
    """The effects of materials and thicknesses, largest first; none where there is no adjoint."""
    from tedm_cli.results.adjoint.file import read_adjoint

    found = read_adjoint(file)
    return [] if isinstance(found, str) else [asdict(effect) for effect in found.materials]


def _loop(file: Reader) -> dict[str, Any]:
    """How stable the loop is, and each noise source with its level and where that is from."""
    from tedm_cli.results.dynamics.loop import read_stability

    found = read_stability(file)
    sources = zip(
        file.strings(DYNAMICS.NOISE_NAME),
        file.strings(DYNAMICS.NOISE_GROUP),
        file.strings(DYNAMICS.NOISE_SPECTRUM),
        file.strings(DYNAMICS.NOISE_ORIGIN),
        strict=True,
    )
    return {
        "poles": found.poles,
        "slowest_pole_rad_s": found.slowest_rad_s,
        "smallest_phase_margin_deg": min((x.phase_deg for x in found.loops if np.isfinite(x.phase_deg)), default=None),
        **{f"noise {name}": f"{spectrum} ({group}; {origin})" for name, group, spectrum, origin in sources},
    }
