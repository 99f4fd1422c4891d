"""The page in Chromium: it draws, shows tedm's numbers, is worked by keys alone, and stays harmless and readable."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import matplotlib.image
import numpy as np
import pytest
from chromium import Browser, chromium
from view_project import GROUP, TITLE, Built

from tedm_cli.results.outputs import read_outputs
from tedm_cli.results.titles import output_title
from tedm_cli.results.wording import capital
from tedm_cli.view.packing import coordinates, numbers, places, steps
from tedm_cli.view.page import page as assembled

pytestmark = [pytest.mark.slow, pytest.mark.skipif(chromium() is None, reason="there is no Chromium on this machine")]
DRAWN = "document.documentElement.dataset.drawn"
CHOOSE = (
    "(id, value) => {const e = document.getElementById(id); e.value = value; e.dispatchEvent(new Event('change'));}"
)
#: what headless Chromium says of reading its own picture
OF_THE_BROWSER = "GL Driver Message"


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with Browser() as started:
        yield started


@pytest.fixture(scope="module")
def page(browser: Browser, built: Built) -> Browser:
    browser.size(1440, 900)
    browser.open(built.path, DRAWN)
    return browser


def choose(page: Browser, **values: object) -> None:
    for name, value in values.items():
        page.value(f"({CHOOSE})({name!r}, {value!r})")
    page.value("new Promise((done) => setTimeout(done, 50))")


def exact(built: Built, temperature: np.ndarray) -> list[float]:
    return [math.fsum(row * temperature) for row in read_outputs(built.project).rows]


def picture(page: Browser, folder: Path) -> np.ndarray:
    """What the canvas shows, [H, W, 3]."""
    page.value("new Promise((done) => setTimeout(done, 450)).then(() => new Promise(requestAnimationFrame))")
    page.screenshot(folder / "page.png")
    box = page.value(
        "(({x, y, width, height}) => [x, y, width, height])(document.getElementById('canvas').getBoundingClientRect())"
    )
    x, y, w, h = (int(v) for v in box)
    return np.asarray(matplotlib.image.imread(folder / "page.png"))[y + 1 : y + h - 1, x + 1 : x + w - 1, :3]


def test_what_is_drawn_changes_with_what_is_warm(page: Browser, tmp_path: Path) -> None:
    choose(page, kind="uniform")
    first = picture(page, tmp_path)
    background = first[0, 0]
    assert 0.03 < (np.abs(first - background).max(axis=2) > 0.1).mean() < 0.9
    choose(page, kind="area", area=0)
    second = picture(page, tmp_path)
    assert (np.abs(second - first).max(axis=2) > 0.05).mean() > 0.01
    page.value("document.getElementById('exaggeration').value = 0;"
               "document.getElementById('exaggeration').dispatchEvent(new Event('input'))")  # fmt: skip
    assert page.value("document.getElementById('drawn').textContent").startswith("Displacements are not drawn")
    page.value("document.getElementById('fit').click()")
    said = page.value("document.getElementById('drawn').textContent")
    assert " times larger: the largest, " in said
    assert "504 grids of 570" in said


def test_corners_are_drawn_where_the_temperatures_put_them(page: Browser, built: Built) -> None:
    """What the graphics card is given are the displacements of mesh, bench and boxes; the picture has them in it."""
    choose(page, kind="area", area=2)
    given = np.array(page.value("Array.from(app.picture.scene.move.array)")).reshape(-1, 4)
    first = 0
    for number in range(3):
        moved = np.array(page.value(f"Array.from(app.picture.layers[{number}].moved)")).reshape(3, -1).T
        np.testing.assert_allclose(given[first : first + len(moved), :3], moved, rtol=1e-6, atol=0)
        assert np.abs(moved).max() > 0
        first += len(moved)
    assert (given[first:] == 0).all()  # test masses, and what is left of the texture


@pytest.mark.parametrize("kind", ["area", "uniform", "typical", "worst", "play", "series"])
def test_outputs_in_the_page_are_those_of_tedm(page: Browser, built: Built, kind: str) -> None:
    choose(page, kind=kind, case=1, area=3)
    if kind in ("play", "series"):
        page.wait("app.film && app.player.film === app.film")
        page.value("app.player.go(100)")
    temperature = np.array(page.value("Array.from(app.temperature)"))
    assert np.abs(temperature).max() > 0
    found, wanted = page.value("Array.from(app.outputs)"), exact(built, temperature)
    rows = read_outputs(built.project).rows
    np.testing.assert_allclose(found, wanted, rtol=1e-12, atol=1e-15 * np.abs(rows * temperature).sum(axis=1).max())
    lines = "Array.from(document.querySelectorAll('#outputs tbody tr'), "
    cells = page.value(f"{lines}(line) => Array.from(line.children, (cell) => cell.textContent))")
    label = built.content["outputs"]["label"]
    judged = ["TM1_a_x", "TM2_a_x", "A_TM1_x", "A_TM2_x", "B_TM1_x", "B_TM2_x"]
    assert [c[0] for c in cells] == [f"{capital(output_title(name))} {name}" for name in judged]
    for name, (_, now, ratio) in zip(judged, cells, strict=True):
        value = wanted[label.index(name)]
        shown, unit = now.replace("−", "-").split(" ")
        prefix = unit.removesuffix("/√Hz").removesuffix("m/s²").removesuffix("m")
        assert float(shown) * 10.0 ** (3 * ("zafpnµm".find(prefix) - 7) if prefix else 0) == pytest.approx(
            value, rel=6e-3
        )
        assert unit.endswith("/√Hz") == (kind in ("typical", "worst"))
        assert (ratio == "–") == (kind in ("play", "series"))
    note = page.value("document.getElementById('read-note').textContent")
    assert ("Ratio to the limit at " in note) != (kind in ("play", "series"))
    assert (" Hz, reading the temperatures as K/√Hz, safety" in note.replace("mHz", " Hz")) == (
        kind in ("area", "uniform")
    )


def test_noise_table_is_the_case_file_at_the_frequency(page: Browser, built: Built) -> None:
    choose(page, kind="typical", case=1, output=3)
    verdict = next(
        v for v in built.content["cases"][1]["verdicts"] if built.content["outputs"]["label"][v["output"]] == "A_TM2_x"
    )
    row = page.value("Array.from(document.querySelectorAll('#noise-table tbody tr')[3].children, (c) => c.textContent)")
    assert row[0] == "Read-out of x, test mass 2, set A A_TM2_x"
    hint = page.value("document.querySelectorAll('#noise-table tbody th')[3].title")
    assert hint == "Limit: LISA Pathfinder, one noise source of the read-out (lpf_readout_item)"
    assert float(row[3]) == pytest.approx(verdict["ratio"], rel=6e-3)
    now = page.value("document.querySelectorAll('#outputs tbody tr')[3].children[1].textContent")
    assert now.lstrip("−") == row[1]
    assert page.value("document.querySelectorAll('#spectrum path').length") == 2


def test_heads_of_columns_are_not_broken_inside_words(page: Browser) -> None:
    """However narrow the table and its numbers are: each is a word in one line."""
    lines = page.value(
        """(() => {
          const shown = document.getElementById('outputs');
          const table = shown.parentElement.insertBefore(shown.cloneNode(true), shown);
          table.style.width = '6rem';
          table.querySelectorAll('td').forEach((cell) => { cell.textContent = '–'; });
          const found = Array.from(table.querySelectorAll('thead th'), (head) => {
            const range = document.createRange();
            range.selectNodeContents(head);
            return [head.textContent, range.getClientRects().length];
          });
          table.remove();
          return found;
        })()"""
    )
    assert lines == [["Output", 1], ["now", 1], ["ratio", 1]]


def test_keys_turn_zoom_and_set_temperatures(page: Browser) -> None:
    choose(page, kind="area", area=0)
    page.value("document.getElementById('canvas').focus()")
    before = page.value("[app.picture.camera.yaw, app.picture.camera.pitch, app.picture.camera.distance]")
    for key in ("ArrowLeft", "ArrowUp", "+"):
        page.key(key)
    after = page.value("[app.picture.camera.yaw, app.picture.camera.pitch, app.picture.camera.distance]")
    assert after[0] > before[0]
    assert after[1] > before[1]
    assert after[2] < before[2]
    page.key("0")
    assert page.value("app.picture.camera.yaw") == pytest.approx(-52 * math.pi / 180)
    page.value("document.querySelector('#sliders input[type=range]').focus()")
    page.key("ArrowRight")
    assert page.value("document.getElementById('kind').value") == "hand"
    label = page.value("document.querySelector('#sliders label').textContent")
    assert "together: " in label
    changed = np.flatnonzero(page.value("Array.from(app.temperature)"))
    assert len(changed) > 1
    page.wait("document.getElementById('live').textContent.startsWith('Largest ratio')")


def test_a_click_on_an_area_warms_it(page: Browser) -> None:
    choose(page, kind="area", area=0)
    page.value("app.picture.camera.look('z')")
    x, y = page.value(
        "(({x, y, width, height}) => [x + width / 2, y + height / 2])(app.picture.canvas.getBoundingClientRect())"
    )
    for kind in ("mousePressed", "mouseReleased"):
        page.send("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", clickCount=1)
    page.wait("document.getElementById('area').value !== '0'")
    chosen = int(page.value("document.getElementById('area').value"))
    assert page.value("Array.from(app.temperature)")[chosen] == 1e-3
    assert page.value("app.data.areas.name[app.picture.area]").startswith("OB_")
    page.value("app.picture.camera.look('iso')")


def controls(node: dict[str, Any]) -> bool:
    return node.get("role", {}).get("value") in (
        "slider",
        "spinbutton",
        "combobox",
        "button",
        "checkbox",
        "application",
    )


def test_a_screen_reader_finds_every_control_by_name(page: Browser) -> None:
    page.value("document.querySelectorAll('details').forEach((d) => {d.open = true})")
    nodes = [n for n in page.send("Accessibility.getFullAXTree")["nodes"] if not n["ignored"] and controls(n)]
    assert len(nodes) > 28 + 20
    assert [n for n in nodes if not n.get("name", {}).get("value", "").strip()] == []
    fields_of_numbers = [n["name"]["value"] for n in nodes if n["role"]["value"] == "spinbutton"]
    assert len(fields_of_numbers) == len(set(fields_of_numbers)) >= 28
    focusable = page.value(
        "Array.from(document.querySelectorAll('select, input, button, canvas')).filter((e) => e.tabIndex < 0).length"
    )
    assert focusable == 0


def test_texts_of_users_do_nothing(page: Browser) -> None:
    assert page.value("typeof pwned") == "undefined"
    assert page.value("document.title") == TITLE
    assert page.value("document.getElementById('sliders').textContent").count(GROUP) >= 2
    assert page.value("document.images.length") == 0
    assert [f for f in page.faults() if OF_THE_BROWSER not in f] == []


def bare(content: dict[str, Any]) -> dict[str, Any]:
    """The same where nothing is required, no film is there, and the layout does not say where its beams run."""
    c = json.loads(json.dumps(content))
    k, f = len(c["areas"]["name"]), c["limits"]["frequency"]["shape"][0]
    c["limits"] |= {"name": [], "amplitude": numbers(np.zeros((0, f)))}
    c["cases"] = [case | {"verdicts": [], "film": None} for case in c["cases"]]
    c["series"], c["drawing"]["boxes"] = [], []
    c["drawing"]["carried"] = {"scale": numbers(np.zeros(k)), "steps": steps(np.zeros((k, 0), dtype=np.int16))}
    c["drawing"]["bench"] |= {
        "position": coordinates(np.zeros((0, 3))), "scale": numbers(np.zeros(k)),
        "steps": steps(np.zeros((k, 0), dtype=np.int16)), "face": places(np.zeros((0, 3))),
        "faceKind": places(np.zeros(0)), "segment": places(np.zeros((0, 2))), "segmentBeam": places(np.zeros(0)),
    }  # fmt: skip
    return c


def test_a_bare_project_is_drawn_as_well(browser: Browser, built: Built, tmp_path: Path) -> None:
    path = tmp_path / "bare.html"
    path.write_text(assembled("bare", bare(built.content)), encoding="utf-8")
    browser.size(1440, 900)
    browser.events.clear()
    browser.open(path, DRAWN)
    choose(browser, kind="uniform")
    assert browser.value("document.querySelectorAll('#others tbody tr').length") == 24
    assert browser.value("document.getElementById('more').textContent") == "24 outputs without a requirement"
    assert browser.value("document.getElementById('read-note').textContent") == "No output has a requirement."
    assert not browser.value("document.getElementById('noise').checkVisibility()")
    assert browser.value("Array.from(document.getElementById('kind').options, (o) => o.value)") == [
        "area",
        "uniform",
        "hand",
    ]
    assert "Beams" not in browser.value("document.getElementById('drawn').textContent")
    assert [f for f in browser.faults() if OF_THE_BROWSER not in f] == []


@pytest.mark.parametrize("dark", [False, True])
def test_a_phone_shows_all_of_it_without_scrolling_sideways(
    browser: Browser, built: Built, tmp_path: Path, dark: bool
) -> None:
    browser.size(390, 844, phone=True, dark=dark)
    browser.open(built.path, DRAWN)
    assert browser.value("document.documentElement.scrollWidth") == 390
    browser.value("scrollTo(0, 700)")
    assert browser.value("document.getElementById('frame').getBoundingClientRect().top") == 0
    light = float(picture(browser, tmp_path)[2, 2].mean())
    assert light < 0.2 if dark else light > 0.9


def test_without_webgl_the_numbers_still_work(built: Built) -> None:
    with Browser("--disable-3d-apis") as bare:
        bare.size(1440, 900)
        bare.open(built.path, "!document.getElementById('fault').hidden")
        assert "offers no WebGL 2" in bare.value("document.getElementById('fault').textContent")
        choose(bare, kind="uniform")
        k = len(built.content["areas"]["name"])
        np.testing.assert_allclose(bare.value("Array.from(app.outputs)"), exact(built, np.full(k, 1e-3)), rtol=1e-9)
        assert not bare.value("document.getElementById('stage').checkVisibility()")
