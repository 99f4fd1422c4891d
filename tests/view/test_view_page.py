"""The page as a file: it fetches nothing, runs nothing but its own program, and is refused where inputs are stale."""

from __future__ import annotations

import base64
import hashlib
import html
import html.parser
import json
import re
import tomllib
import zlib
from pathlib import Path

import numpy as np
import pytest
from view_project import GROUP, REASON, ROOT, SAMPLES, TITLE, Built, content_of

from tedm_cli.cli import main
from tedm_cli.config.project import Project, load_project
from tedm_cli.contracts import SENSITIVITY, SERIES
from tedm_cli.errors import InputError, TedmError
from tedm_cli.files.store import open_checked
from tedm_cli.noise.areas import AreaTable
from tedm_cli.progress import silent
from tedm_cli.results.build_folder import open_results
from tedm_cli.results.outputs import read_outputs
from tedm_cli.stages.reporting.view import view
from tedm_cli.stages.reporting.view_series import MOST_SAMPLES, series_films
from tedm_cli.view.page import SCRIPTS, inert_json, page, page_part


class Parsed(html.parser.HTMLParser):
    """Elements with their attributes, ids, and the text of scripts and styles."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.inside: dict[str, list[str]] = {"script": [], "style": [], "title": [], "h1": []}
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))

    def handle_data(self, data: str) -> None:
        if self.tags and self.tags[-1][0] in self.inside and data.strip():
            self.inside[self.tags[-1][0]].append(data)

    def all(self, tag: str) -> list[dict[str, str | None]]:
        return [a for t, a in self.tags if t == tag]


def digest(text: str) -> str:
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"


def test_the_page_runs_its_own_program_and_reaches_nothing(built: Built) -> None:
    found = Parsed(built.text)
    assert [a.get("type") for a in found.all("script")] == ["application/json", None]
    assert len(found.all("style")) == 1
    program, style = found.inside["script"][-1], found.inside["style"][0]
    policy = next(str(a["content"]) for a in found.all("meta") if a.get("http-equiv") == "Content-Security-Policy")
    assert policy == (
        f"default-src 'none'; script-src {digest(program)}; style-src {digest(style)};"
        " base-uri 'none'; form-action 'none'"
    )
    assert not {name for _, attrs in found.tags for name in attrs} & {"src", "href", "style", "srcset", "action"}
    assert not [name for _, attrs in found.tags for name in attrs if name.startswith("on")]
    assert not {t for t, _ in found.tags} & {"link", "img", "iframe", "object", "embed", "base", "form"}
    for word in ("http:", "https:", "fetch(", "XMLHttpRequest", "import(", "innerHTML", "eval(", "document.write"):
        assert word not in program.replace("http://www.w3.org/2000/svg", ""), word
    assert "url(" not in style
    ids = [a["id"] for _, a in found.tags if "id" in a]
    assert len(ids) == len(set(ids))
    wanted = set(re.findall(r'(?:getElementById|field)\("([\w-]+)"\)', program))
    assert len(wanted) > 30
    assert wanted <= set(ids)


def test_every_control_has_a_name(built: Built) -> None:
    """Labels hold their control; buttons have text or a name."""
    body = built.text[built.text.index("<body>") : built.text.index('<script type="application/json"')]
    labels = re.findall(r"<label.*?</label>", body, re.S)
    assert all(re.search(r"\w", re.sub("<[^>]*>", "", label)) for label in labels)
    outside = re.sub(r"<label.*?</label>", "", body, flags=re.S)
    assert not re.findall(r"<(?:select|input)\b[^>]*>", outside)
    for attributes, text in re.findall(r"<button([^>]*)>(.*?)</button>", body, re.S):
        assert re.search(r"\w", text) or "aria-label" in attributes
    assert re.search(r'role="status" aria-live="polite"', body)


def test_texts_are_text(built: Built) -> None:
    assert html.unescape(re.findall("<title>(.*?)</title>", built.text, re.S)[0]) == TITLE
    assert html.unescape(re.findall("<h1>(.*?)</h1>", built.text, re.S)[0]) == TITLE
    assert built.content["title"] == TITLE
    assert GROUP in built.content["areas"]["group"]
    assert built.content["cases"][0]["reason"] == REASON
    assert built.text.count("<script") == built.text.count("</script>") == 2
    assert "<img" not in built.text
    assert "{{" not in built.text.replace("{{program}}", "")


@pytest.mark.parametrize(
    "text", ["</script><script>", "<!--", "]]>", "\u2028\u2029", "&lt;", "🛰️", '"\\', "{{title}}", "\x00"]
)
def test_json_is_inert_and_comes_back(text: str) -> None:
    packed = inert_json({"key": [text, {text: 1.5}]})
    assert not set(packed) & set("<>&\u2028\u2029\x00")
    assert json.loads(packed) == {"key": [text, {text: 1.5}]}
    whole = page(text, {"key": text})
    assert content_of(whole) == {"key": text}
    assert whole.count("<script") == 2


def test_every_part_of_the_page_is_in_the_package() -> None:
    folder = ROOT / "tedm_cli" / "view" / "page"
    there = {p.name for p in folder.iterdir()}
    assert there == {*SCRIPTS, "page.css", "page.html"}
    data = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["setuptools"]["package-data"]
    covered = {p.name for pattern in data["tedm_cli.view"] for p in (ROOT / "tedm_cli" / "view").glob(pattern)}
    assert covered == there
    for name in there:
        text = page_part(name)
        assert len(text.splitlines()) <= 370
        assert "</script" not in text or name == "page.html"


def test_what_the_page_says_of_the_model(built: Built) -> None:
    drawing = built.content["drawing"]
    assert drawing["grids"] == 570
    assert drawing["cell"] == 0.0
    assert [b["kind"] for b in drawing["boxes"]] == ["compensation mass", "test mass", "test mass"]
    corner = np.array(drawing["boxes"][0]["corner"])
    centre = (corner.min(axis=0) + corner.max(axis=0)) / 2
    np.testing.assert_allclose(centre, [-0.1, 0.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(np.ptp(corner, axis=0), [0.01, 0.03, 0.03])
    with open_checked(built.project.build_dir / "sensitivity.h5", SENSITIVITY) as file:
        t, turn = file.array(SENSITIVITY.COMPENSATION_TRANSLATION), file.array(SENSITIVITY.COMPENSATION_ROTATION)
    carried = drawing["carried"]
    scale = np.frombuffer(base64.b64decode(carried["scale"]["float64"]), dtype="<f8")
    low, high = np.frombuffer(zlib.decompress(base64.b64decode(carried["steps"]["int16"])), np.uint8).reshape(2, -1)
    steps = np.cumsum((low + 256 * high.astype(np.int64)).astype(np.int16).reshape(len(t), -1), axis=1, dtype=np.int16)
    found = (scale[:, None] * steps).reshape(len(t), 3, 36)  # areas, x y z, corners of the block alone
    wanted = t[:, :1] + np.cross(turn[:, :1], corner - centre)
    np.testing.assert_allclose(found.swapaxes(1, 2), wanted, rtol=0, atol=2e-5 * np.abs(wanted).max())
    names = {s["name"] for s in built.content["sources"]}
    assert names >= {"unit_loads.h5", "distortion.h5", "sensitivity.h5", "optics.h5", "case01.h5", "case03.h5"}
    for source in built.content["sources"]:
        path = built.project.build_dir / source["name"]
        assert source["sha256"] == hashlib.sha256(path.read_bytes()).hexdigest()
    assert [c["id"] for c in built.content["cases"]] == ["1", "3", "7", "10"]
    assert len(built.text) < 1_000_000


def film_values(project: Project) -> tuple[AreaTable, np.ndarray, np.ndarray, str]:
    with open_results(project) as results:
        outputs = read_outputs(project)
        areas = outputs.areas
        (name, film), *more = series_films(project, results, outputs, None)
    assert (name, more) == ("warm", [])
    return areas, film.time_s, film.temperature.values(), film.words


def test_a_series_is_thinned_and_rid_of_its_trend(built: Built) -> None:
    """The outputs of the thinned temperatures are samples of the series that run-series wrote."""
    areas, time, values, words = film_values(built.project)
    assert MOST_SAMPLES / 2 < len(time) <= MOST_SAMPLES
    assert f"of {SAMPLES:,}" in words
    assert "linear trend removed" in words
    ramp = values[areas.shield == "inside"]
    assert np.abs(ramp[areas.group[areas.shield == "inside"] != "OB"]).max() < 1e-8  # a line, and nothing after it
    outputs = read_outputs(built.project)
    with open_checked(built.project.build_dir / "series_warm.h5", SERIES) as file:
        all_times = file.array(SERIES.TIME)
        at = np.searchsorted(all_times, time)
        np.testing.assert_array_equal(all_times[at], time)
        for label in ("TM1_a_x", "A_TM2_x"):
            exact = file.array(SERIES.SERIES.of(label))[at]
            row = outputs.rows[outputs.labels.index(label)]
            room = np.abs(row) @ np.abs(values).max(axis=1) / 32767
            np.testing.assert_allclose(row @ values, exact, rtol=0, atol=room)
            assert np.abs(exact).max() > 100 * room


def test_realisations_are_correlated_as_their_case_says(built: Built) -> None:
    """Areas that move together have one temperature; those of different blocks do not."""
    shield = np.array(built.content["areas"]["shield"])
    found = {}
    for case in built.content["cases"]:
        film = case["film"]
        k, count = film["steps"]["shape"]
        raw = np.frombuffer(zlib.decompress(base64.b64decode(film["steps"]["int16"])), np.uint8).reshape(2, k, count)
        change = raw[0].astype(np.uint16) | (raw[1].astype(np.uint16) << 8)
        step = np.cumsum(change, axis=1, dtype=np.uint16).view(np.int16)
        scale = np.frombuffer(base64.b64decode(film["scale"]["float64"]))
        found[case["id"]] = scale[:, None] * step
        assert "seed 1" in film["words"]
    one, three = found["1"], found["3"]
    outside = shield == "outside"
    same = np.corrcoef(one)
    assert same.min() > 1 - 1e-6
    assert one[outside].std() == pytest.approx(10 * one[~outside].std(), rel=1e-3)
    mixed = np.corrcoef(three)
    assert mixed[np.ix_(outside, outside)].min() > 1 - 1e-6
    assert np.abs(mixed[np.ix_(outside, ~outside)]).max() < 0.5
    late = found["10"][np.array(built.content["areas"]["name"]) == "STRUT_1"][0]
    assert np.abs(late).max() > 0


def test_the_page_is_the_same_every_time(built: Built, tmp_path: Path) -> None:
    again = view(built.project, tmp_path / "again.html", silent)
    assert again.path.read_text(encoding="utf-8") == built.text
    assert (again.drawn, again.grids, again.cases, again.series) == (504, 570, 4, 1)


def test_a_coarser_page_says_so(built: Built, tmp_path: Path) -> None:
    done = view(built.project, tmp_path / "coarse.html", silent, most_numbers=3 * 28 * 300)
    content = content_of(done.path.read_text(encoding="utf-8"))
    assert done.drawn == content["drawing"]["mesh"]["position"]["shape"][0] <= 300
    assert content["drawing"]["cell"] > 0.0
    assert done.path.stat().st_size < len(built.text.encode())


@pytest.mark.parametrize(
    ("name", "fact"),
    [
        ("cases.toml", "case01.h5"),
        ("optics.toml", "optics.h5"),
        ("model.toml", "sensitivity.h5"),
        ("warm.csv", "series_warm.h5"),
    ],
)
def test_stale_inputs_are_refused(built: Built, tmp_path: Path, name: str, fact: str) -> None:
    path = built.project.cases.parent / name
    before = path.read_bytes()
    try:
        path.write_bytes(before + (b"\n" if name == "warm.csv" else b"# changed\n"))
        with pytest.raises(InputError, match="is stale") as refused:
            view(load_project(built.project.file.path, built.project.build_dir), tmp_path / "view.html", silent)
        assert Path(refused.value.where).name == fact
        assert "rebuild it with" in refused.value.hint
    finally:
        path.write_bytes(before)
    assert not (tmp_path / "view.html").exists()


def test_a_missing_case_is_named(built: Built, tmp_path: Path) -> None:
    case = built.project.build_dir / "case03.h5"
    case.rename(tmp_path / "case03.h5")
    try:
        with pytest.raises(TedmError, match="not run yet: 3"):
            view(built.project, tmp_path / "view.html", silent)
    finally:
        (tmp_path / "case03.h5").rename(case)


def test_command(
    built: Built, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "page.html"
    words = ["tedm", "view", "-c", str(built.project.file.path), "-d", str(built.project.build_dir), "-o", str(out)]
    monkeypatch.setattr("sys.argv", words)
    with pytest.raises(SystemExit) as left:
        main()
    assert not left.value.code
    said = capsys.readouterr()
    assert said.out == f"{out}: {out.stat().st_size / 1e6:.2f} MB, 504 of 570 grids drawn\n"
    assert out.read_text(encoding="utf-8") == built.text
