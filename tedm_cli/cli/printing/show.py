"""What a file says and holds, as lines of text: verdicts first."""

from __future__ import annotations

from typing import Any

from tedm_cli.cli.printing.adjoint import material_lines
from tedm_cli.cli.printing.table import above_rounding, table
from tedm_cli.results.wording import chance_text, count, ratio_text


def show_lines(d: dict[str, Any], most: int | None) -> list[str]:
    """What `show_dict` found, for a person: verdicts or main numbers, where it is from, what it holds."""
    versions = ", ".join(
        f"{k.removesuffix('_version')} {v}" for k, v in d["attributes"].items() if k.endswith("_version")
    )
    origin = [f"{d['kind']}, made by `{d['made_by']}`", f"command: {d['attributes']['command_line']}", versions]
    inputs = [f"from {i['path']} sha256 {i['sha256'][:16]}..." for i in d["configurations"] + d["inputs"]]
    judged = {f"{v['output']} {v['requirement']}" for v in d["verdicts"] or ()}
    return [
        *_verdict_lines(d, most),
        *(f"{key}: {_value(value)}" for key, value in d["main"].items() if key not in judged),
        *material_lines(d.get("materials", []), most),
        *_uncertainty_lines(d),
        "",
        *origin,
        *inputs,
        "",
        *table(("dataset", "shape", "unit", "meaning"), [_row(s) for s in d["datasets"]]),
    ]


def _verdict_lines(d: dict[str, Any], most: int | None) -> list[str]:
    """The verdict in the first line, then a table, worst first; what the file is, where nothing is judged."""
    verdicts = d["verdicts"]
    if not verdicts:
        return [f"{d['file']}: {d['kind']}{'' if verdicts is None else ', nothing judged'}"]
    worst, failed = verdicts[0], sum(not v["passed"] for v in verdicts)
    total = count(len(verdicts), "verdict")
    said = f"FAIL, {failed} of {total} violated" if failed else f"pass, {total}"
    sure = _chances(d)
    rows = [
        (
            v["output"],
            v["requirement"],
            ratio_text(v["ratio"]),
            *([sure[v["output"], v["requirement"]]] if sure else []),
            "pass" if v["passed"] else "FAIL",
        )
        for v in verdicts[:most]
    ]
    head = ("output", "requirement", "ratio", *(["P(violated)"] if sure else []), "verdict")
    more = len(verdicts) - len(rows)
    return [
        f"{d['file']}: {said}; worst: {worst['output']}, {worst['requirement']}, ratio {ratio_text(worst['ratio'])}",
        *table(head, rows, right=(2, 3) if sure else (2,)),
        *([f"and {more} more (--top 0: all)"] if more else []),
    ]


def _uncertainty_lines(d: dict[str, Any]) -> list[str]:
    """Of how many parameters the probabilities are, and what they lack."""
    found = d.get("uncertainty")
    if found is None:
        return []
    chance = chance_text(*(found["any_violated"][key] for key in ("probability", "low", "high")))
    return [
        f"probability that any is violated: {chance}, by {count(len(found['parameters']), 'uncertain parameter')}",
        *(f"left out of the uncertainty: {what}" for what in found["left_out"]),
    ]


def _chances(d: dict[str, Any]) -> dict[tuple[str, str], str]:
    """The probability that each verdict is a violation, by output and requirement; none where nothing is uncertain."""
    found = d.get("uncertainty")
    if found is None:
        return {}
    return {
        (v["output"], v["requirement"]): chance_text(*(v["violated"][key] for key in ("probability", "low", "high")))
        for v in found["verdicts"]
    }


def _value(value: Any) -> str:
    """Numbers with the digits that say something; what is rounding beside its neighbours is 0."""
    if isinstance(value, list):
        scale = max(map(abs, value), default=0.0)
        return f"[{', '.join(f'{above_rounding(v, scale):.5g}' for v in value)}]"
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _row(s: dict[str, Any]) -> tuple[str, str, str, str]:
    return s["path"], " x ".join(str(n) for n in s["shape"]) or "scalar", s["units"], s["long_name"]
