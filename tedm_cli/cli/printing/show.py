"""What a file holds, as lines of text."""

from __future__ import annotations

from typing import Any

from tedm_cli.cli.printing.table import table


def show_lines(d: dict[str, Any]) -> list[str]:
    """What `show_dict` found, for a person."""
    versions = ", ".join(
        f"{k.removesuffix('_version')} {v}" for k, v in d["attributes"].items() if k.endswith("_version")
    )
    lines = [f"{d['file']}: {d['kind']} (made by `{d['made_by']}`)", f"command: {d['attributes']['command_line']}"]
    lines += [versions, *(f"from {i['path']} sha256 {i['sha256'][:16]}..." for i in d["configurations"] + d["inputs"])]
    lines += ["", *table(("dataset", "shape", "unit", "meaning"), [_row(s) for s in d["datasets"]])]
    if d["main"]:
        lines += ["", *(f"{k}: {v}" for k, v in d["main"].items())]
    return lines


def _row(s: dict[str, Any]) -> tuple[str, str, str, str]:
    return s["path"], " x ".join(str(n) for n in s["shape"]) or "scalar", s["units"], s["long_name"]
