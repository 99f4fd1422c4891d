"""Whether the values of a file are among those that its contract knows: words, names, rows of other datasets."""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from tedm_cli.arrays import AnyArray, IntArray
from tedm_cli.contracts import Dataset, FileKind
from tedm_cli.contracts.spec import Values
from tedm_cli.files.blocks import reading
from tedm_cli.files.datasets import opened

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
    return problems + _family_problems(file, kind, held) + _lonely(kind, held)


def _family_problems(file: Any, kind: FileKind, held: dict[str, Dataset]) -> list[str]:
    """Members of families that no name belongs to, and members that families lack."""
    problems = []
    members: dict[tuple[str, str], dict[str, set[str]]] = {}  # of the optional families of one group
    for pattern, spec in kind.datasets.items():
        names = [kind.families.get(brace, "") for brace in re.findall(r"{(\w+)}", pattern)]
        if not names or any(name not in held for name in names):
            continue
        known = itertools.product(*(_texts(file[name][()]) for name in names))
        wanted = [spec.of(*each) for each in known]
        template = re.compile(re.sub(r"\\{\w+\\}", "[^/]+", re.escape(pattern)))
        found = [path for path in held if template.fullmatch(path)]
        problems += [f"{path} has no name in {' and '.join(names)}" for path in sorted(set(found) - set(wanted))]
        group = pattern.partition("/{")[0]
        if spec.optional:
            here = {path.removeprefix(f"{group}/") for path in found}
            members.setdefault((group.rpartition("/")[0], names[0]), {})[group] = here
        else:
            problems += [f"has no {path}" for path in wanted if path not in held]
    for families in members.values():
        every = set().union(*families.values())
        problems += [
            f"has no {group}/{name}" for group, found_here in families.items() for name in sorted(every - found_here)
        ]
    return problems


def _lonely(kind: FileKind, held: dict[str, Dataset]) -> list[str]:
    """Optional datasets that a file lacks though it has others of their group."""
    present = {id(spec) for spec in held.values()}
    optional = {path: spec for path, spec in kind.datasets.items() if spec.optional}
    groups = {spec.comes_with for spec in optional.values() if id(spec) in present}
    missing = [path for path, spec in optional.items() if id(spec) not in present]
    return [f"has no {path}, but others of its group" for path in missing if optional[path].comes_with in groups]


def _problem(file: Any, path: str, spec: Dataset, dims: dict[str, int]) -> str:
    rule, data = spec.values, opened(file, path)
    if rule.unique and (problem := _twice(np.atleast_1d(data[()]))):
        return problem
    if spec.dtype == "str":
        names = _texts(file[rule.of][()]) if rule.of and rule.of in file else []
        if rule.ends:
            return _no_label(_texts(data[()]), names, rule, file)
        return _unknown(data, rule.words or (*names, *[""] * rule.none)) if rule.words or names else ""
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


def _no_label(labels: list[str], names: list[str], rule: Values, file: Any) -> str:
    """The first label that is not a name and a quantity: any of `names`, or those of `rule.parts_of` in turn."""
    turns = _texts(file[rule.parts_of][()]) if rule.parts_of else []
    for place, label in enumerate(labels):
        end = next((end for end in rule.ends if label.endswith(f"_{end}")), "")
        name = label.removesuffix(f"_{end}")
        if not end:
            return f"is {label!r} at {place}, wanted an end of {', '.join(rule.ends)}"
        if names and name not in names:
            return f"is {label!r} at {place}, wanted a beginning of {rule.of}"
        if turns and name != (turn := turns[place * len(turns) // len(labels)]):
            return f"is {label!r} at {place}, wanted {turn}_{end}"
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
    low, high = -(2**63), 2**63 - 1
    if rule.flag:
        low, high = 0, 1
    elif rule.rows_of:
        low, high = -1 if rule.none else 0, dims.get(rule.rows_of, 0) - 1
    elif rule.least is not None:
        low = rule.least
    before: IntArray = np.zeros(0, dtype=np.int64)
    for start, block in _blocks(data):
        wrong = np.flatnonzero((block < low) | (block > high))
        if wrong.size:
            wanted = f"{low} to {high}" if high < 2**63 - 1 else f"at least {low}"
            return f"is {block[wrong[0]]} at {start + wrong[0]}, wanted {wanted}"
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
