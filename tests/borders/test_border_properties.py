"""Whatever is in a file: an answer, or a refusal that names the place. Never anything else."""

from __future__ import annotations

import copy
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from border_tools import CONFIGS, MODEL_TOML, SMALL
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from tedm_cli.areas.csv_file import read_area_csv
from tedm_cli.config.base import Strict, validate
from tedm_cli.config.cases import CasesConfig
from tedm_cli.config.model.file import ModelConfig
from tedm_cli.config.optics.tables import OpticsTables
from tedm_cli.errors import ConfigError, InputError

QUICK = settings(max_examples=50, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])

lines = st.lists(
    st.one_of(
        st.from_regex(r"[0-9]{1,12},[A-Za-z][A-Za-z0-9_]{0,6}", fullmatch=True),
        st.text(alphabet='0123456789,"ABC_ \t²٣é\x00', max_size=20),
        st.text(max_size=20),
    ),
    max_size=12,
)


@QUICK
@given(lines=lines)
@example(lines=["²,A"])
@example(lines=["99999999999999999999,A"])
@example(lines=["0,A"])
@example(lines=['1,"A'])
@example(lines=["1,A\x00"])
@example(lines=["1,É"])
def test_area_csv_of_any_text(tmp_path: Path, lines: list[str]) -> None:
    path = tmp_path / "areas.csv"
    path.write_text("\n".join(["node_id,area", *lines]), encoding="utf-8", errors="surrogatepass")
    try:
        areas = read_area_csv(path)
    except InputError as exc:
        refused_at = exc.where
    else:
        refused_at = ""
    if refused_at:
        assert refused_at.startswith(str(path))
        return
    ids = [int(i) for members in areas.values() for i in members]
    assert len(ids) == len(set(ids)) > 0
    assert min(ids) >= 1
    assert len({name.upper() for name in areas}) == len(areas)
    assert all(name.isascii() and len(members) for name, members in areas.items())


@QUICK
@given(contents=st.binary(max_size=200))
@example(contents=b"node_id,area\n1,\xff\n")
def test_area_csv_of_any_bytes(tmp_path: Path, contents: bytes) -> None:
    path = tmp_path / "areas.csv"
    path.write_bytes(contents)
    with pytest.raises(InputError) as caught:
        read_area_csv(path)
    assert caught.value.where.startswith(str(path))


def tables(data: Any, path: str = "") -> Iterator[tuple[str, dict[str, Any]]]:
    """Every table of a document with its dotted path."""
    if isinstance(data, dict):
        yield path, data
        for key, value in data.items():
            yield from tables(value, f"{path}.{key}" if path else key)
    elif isinstance(data, list):
        for i, value in enumerate(data):
            yield from tables(value, f"{path}[{i}]")


DOCUMENTS: dict[str, tuple[type[Strict], dict[str, Any], set[str]]] = {
    "model": (ModelConfig, tomllib.loads(MODEL_TOML), {"model.subcases", "gravity.subsystems"}),
    "small": (
        ModelConfig,
        tomllib.loads((SMALL / "model.toml").read_text()),
        {"model.subcases", "gravity.subsystems", "gravity.subsystems.IS"},
    ),
    "cases": (CasesConfig, tomllib.loads((CONFIGS / "cases.toml").read_text()), set()),
    "optics": (OpticsTables, tomllib.loads((CONFIGS / "optics.toml").read_text()), {"sets"}),
}
keys = st.text(alphabet="abcdefghijklmnopqrstuvwxyz_", min_size=1, max_size=8).map(lambda key: f"zz_{key}")


@QUICK
@given(data=st.data())
@pytest.mark.parametrize("name", DOCUMENTS)
def test_unknown_keys_anywhere_are_reported_by_path(name: str, data: st.DataObject) -> None:
    model, document, free = DOCUMENTS[name]
    validate(model, document, where="x.toml")  # the document itself is good
    changed = copy.deepcopy(document)
    places = [(path, table) for path, table in tables(changed) if path not in free]
    expected = set()
    for path, table in data.draw(st.lists(st.sampled_from(places), min_size=1, max_size=4, unique_by=lambda p: p[0])):
        key = data.draw(keys)
        table[key] = data.draw(st.one_of(st.integers(), st.text(max_size=3), st.lists(st.integers(), max_size=2)))
        expected.add(f"{path}.{key}" if path else key)
    with pytest.raises(ConfigError) as caught:
        validate(model, changed, where="x.toml")
    assert {path for path, _ in caught.value.problems} == expected
    assert all(fact.startswith("unknown key") for _, fact in caught.value.problems)


@QUICK
@given(data=st.data())
@pytest.mark.parametrize("name", DOCUMENTS)
def test_missing_and_malformed_values_are_reported_at_their_place(name: str, data: st.DataObject) -> None:
    """Whatever one value is exchanged for, all problems are at it, below it, or those of its table as a whole."""
    model, document, _ = DOCUMENTS[name]
    changed = copy.deepcopy(document)
    path, table = data.draw(st.sampled_from([(p, t) for p, t in tables(changed) if t]))
    key = data.draw(st.sampled_from(sorted(table)))
    junk = st.one_of(
        st.none(), st.booleans(), st.integers(), st.floats(), st.text(max_size=3), st.just([]), st.just({})
    )
    table[key] = data.draw(junk)
    place = f"{path}.{key}" if path else key
    try:
        validate(model, changed, where="x.toml")
    except ConfigError as exc:
        for reported, fact in exc.problems:
            assert reported in (path, place) or reported.startswith((f"{place}.", f"{place}[")), (reported, fact)
            assert "constrained" not in reported
            assert fact
