"""Whether the values of a file are among those that its contract knows: words, names, rows of other datasets."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from tedm_cli.arrays import AnyArray, IntArray
from tedm_cli.contracts import Dataset, FileKind
from tedm_cli.contracts.spec import Values
from tedm_cli.files.blocks import reading

_BLOCK = 1 << 20  # values looked at together
_SHOWN = 8  # words of a list that a message quotes


def value_problems(file: Any, kind: FileKind, held: dict[str, Dataset], dims: dict[str, int], where: Path) -> list[str]:
    """What is wrong with the values of the datasets `held` by an open file, whose shapes fit; one line for each."""
    problems = []
    for path, spec in held.items():
        if spec.values != Values():
            with reading(where, path):
                problem = _problem(file, path, spec, dims)
            problems += [f"{path} {problem}"] * bool(problem)
    for pattern in kind.datasets:
        names = kind.families.get(pattern.rpartition("/{")[2].rstrip("}"), "") if "{" in pattern else ""
        if names in held:
            group = pattern.rsplit("/", 1)[0]
            known = set(_texts(file[names][()]))
            stray = [path for path in held if path.rsplit("/", 1)[0] == group and path.rsplit("/", 1)[1] not in known]
            problems += [f"{path} has no name in {names}" for path in stray]
    return problems


def _problem(file: Any, path: str, spec: Dataset, dims: dict[str, int]) -> str:
    rule, data = spec.values, file[path]
    if rule.unique and (problem := _twice(np.atleast_1d(data[()]))):
        return problem
    if rule.words or rule.of in file:
        return _unknown(data, rule.words or tuple(_texts(file[rule.of][()])))
    if rule.starts_in in dims:
        return _edges(data, dims[rule.starts_in], rule.starts_in)
    return _integers(data, rule, dims)


def _unknown(data: Any, known: tuple[str, ...]) -> str:
    words = [word.encode() for word in known]
    for start, block in _blocks(data):
        left = np.arange(len(block))
        for word in words:  # few words, many values: faster than to sort them
            left = left[block[left] != word]
        if left.size:
            wanted = f"one of {', '.join(known)}" if len(known) <= _SHOWN else f"one of the {len(known)} known"
            return f"is {_texts(block[left[:1]])[0]!r} at {start + int(left[0])}, wanted {wanted}"
    return ""


def _twice(values: AnyArray) -> str:
    shown = _texts(values) if values.dtype.kind == "S" else values.tolist()
    if "" in shown:
        return f"has no name at {shown.index('')}"
    seen: set[Any] = set()
    for value in shown:
        if value in seen:
            return f"has {value!r} twice"
        seen.add(value)
    return ""


def _edges(data: Any, length: int, dim: str) -> str:
    edges = data[()]
    if edges[0] != 0 or edges[-1] != length or np.any(np.diff(edges) < 0):
        return f"must rise from 0 to {length}, the length of {dim}"
    return ""


def _integers(data: Any, rule: Values, dims: dict[str, int]) -> str:
    if not (rule.flag or rule.rows_of or rule.ascending):
        return ""
    low, high = (0, 1) if rule.flag else (-1 if rule.none else 0, dims.get(rule.rows_of, 0) - 1)
    before: IntArray = np.zeros(0, dtype=np.int64)
    for start, block in _blocks(data):
        if rule.flag or rule.rows_of:
            wrong = np.flatnonzero((block < low) | (block > high))
            if wrong.size:
                return f"is {block[wrong[0]]} at {start + wrong[0]}, wanted {low} to {high}"
        if rule.ascending:
            falls = np.flatnonzero(np.diff(np.concatenate([before, block])) <= 0)
            if falls.size:
                return f"does not ascend at {start + int(falls[0]) + 1 - len(before)}"
            before = block[-1:]
    return ""


def _blocks(data: Any) -> Iterator[tuple[int, AnyArray]]:
    """The values in order, flat, and the place of the first of each block."""
    if data.ndim != 1:
        if data.size:
            yield 0, np.atleast_1d(data[()]).ravel()
        return
    for start in range(0, len(data), _BLOCK):
        yield start, data[start : start + _BLOCK]


def _texts(values: AnyArray) -> list[str]:
    return [v.decode("utf-8", "replace") for v in np.atleast_1d(values).tolist()]
