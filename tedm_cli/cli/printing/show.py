"""What a file says and holds, as lines of text: verdicts first."""

from __future__ import annotations

from typing import Any

from tedm_cli.cli.printing.adjoint import material_lines
from tedm_cli.cli.printing.table import above_rounding, table
from tedm_cli.results.wording import count, ratio_text


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
    rows = [
        (v["output"], v["requirement"], ratio_text(v["ratio"]), "pass" if v["passed"] else "FAIL")
        for v in verdicts[:most]
    ]
    more = len(verdicts) - len(rows)
    return [
        f"{d['file']}: {said}; worst: {worst['output']}, {worst['requirement']}, ratio {ratio_text(worst['ratio'])}",
        *table(("output", "requirement", "ratio", "verdict"), rows, right=(2,)),
        *([f"and {more} more (--top 0: all)"] if more else []),
    ]


def _value(value: Any) -> str:
    """Numbers with the digits that say something; what is rounding beside its neighbours is 0."""
    if isinstance(value, list):
        scale = max(map(abs, value), default=0.0)
        return f"[{', '.join(f'{above_rounding(v, scale):.5g}' for v in value)}]"
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _row(s: dict[str, Any]) -> tuple[str, str, str, str]:
    return s["path"], " x ".join(str(n) for n in s["shape"]) or "scalar", s["units"], s["long_name"]
