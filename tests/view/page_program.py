"""The page's arithmetic without a browser, in V8."""

from __future__ import annotations

import base64
import json
import zlib
from typing import Any

import numpy as np
from py_mini_racer import MiniRacer

from tedm_cli.view.page import page_part


class Program:
    """Parts of the page's program that need no document; what goes in and out is JSON."""

    def __init__(self, *parts: str) -> None:
        self.engine = MiniRacer()
        for part in parts:
            self.engine.eval(page_part(part))

    def run(self, expression: str, **given: Any) -> Any:
        """The value of an expression of the `given` names; arrays become Float64Array, and NaN stays NaN."""
        names = ", ".join(given)
        values = ", ".join(_literal(v) for v in given.values())
        text = self.engine.eval(
            f"JSON.stringify((({names}) => ({expression}))({values}), (key, v) =>"
            " typeof v === 'number' ? (Object.is(v, -0) ? '-0' : v !== v ? 'nan' : Math.abs(v) === Infinity ? String(v)"
            " : v) : ArrayBuffer.isView(v) ? Array.from(v) : v)"
        )
        return _numbers(json.loads(str(text)))


def inflated(packed: dict[str, Any], kind: str) -> str:
    """What the browser inflates of an array, as base64."""
    return base64.b64encode(zlib.decompress(base64.b64decode(packed[kind]))).decode()


def _literal(value: Any) -> str:
    if isinstance(value, np.ndarray):
        return f"Float64Array.from({_literal(value.reshape(-1).tolist())})"
    if isinstance(value, list):
        return f"[{', '.join(_literal(v) for v in value)}]"
    if isinstance(value, float) and not np.isfinite(value):
        return "NaN" if np.isnan(value) else f"{'-' if value < 0 else ''}Infinity"
    return json.dumps(value)


def _numbers(value: Any) -> Any:
    if isinstance(value, list):
        return [_numbers(v) for v in value]
    if isinstance(value, dict):
        return {k: _numbers(v) for k, v in value.items()}
    special = {"nan": np.nan, "Infinity": np.inf, "-Infinity": -np.inf, "-0": -0.0}
    return special.get(value, value) if isinstance(value, str) else value
