"""What a person would find wrong in a layout: each mistake is made once, and found with its place and size."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tedm_cli.cli import main
from tedm_cli.optics.layout import Element, OpticalLayout, Recombination, Tolerances
from tedm_cli.optics.layout_checks import Finding, check_layout, failures
from tedm_cli.optics.obstruction import obstructions

Change = Callable[[Element], Element]


def with_element(layout: OpticalLayout, name: str, change: Change) -> OpticalLayout:
    return replace(layout, elements=tuple(change(e) if e.name == name else e for e in layout.elements))


def shifted(e: Element, by: tuple[float, float, float]) -> Element:
    return replace(e, ref_m=tuple(np.add(e.ref_m, by)))


def turned(e: Element, about_z_rad: float) -> Element:
    return replace(e, normal=tuple(Rotation.from_rotvec([0, 0, about_z_rad]).apply(e.normal)))


def lines(layout: OpticalLayout, severity: str = "error") -> list[str]:
    return [f.line for f in failures(check_layout(layout), severity)]  # type: ignore[arg-type]


def test_the_shipped_layout_has_nothing_to_complain_about(layout: OpticalLayout) -> None:
    findings = check_layout(layout)
    assert all(f.passed for f in findings)
    assert all(e.aperture_m is not None for e in layout.elements)
    hits = [f for f in findings if f.check == "aperture"]
    assert (
        len(hits) == sum(2 if s.op == "T" else 1 for p in layout.paths for s in p.steps[1:]) + 2 * 2
    )  # BS4, BS5 from behind
    assert {f.check for f in findings} == {
        "aperture",
        "overlap",
        "angle",
        "path_mismatch",
        "reference_point",
    }


def test_a_hit_outside_the_aperture_says_by_how_much(layout: OpticalLayout) -> None:
    """M4 slides 8 mm in its own plane: the beam goes on as before, 8 mm - (7 - 1.5) mm outside."""
    change: Change = lambda e: shifted(e, (0.0, 0.0, 8e-3))  # noqa: E731
    found = lines(with_element(layout, "M4", change))
    assert len(found) == 2  # on both photodiodes of the interferometer
    assert found[0].startswith("path PD12A meas, step 9 (M4:R): the beam meets M4 2.5 mm outside its aperture")
    assert "1.5 mm of clearance" in found[0]
    assert "move M4" in found[0]


def test_both_faces_of_a_plate_and_the_sides_of_a_rectangle(layout: OpticalLayout) -> None:
    small = with_element(layout, "BS1", lambda e: replace(e, aperture_m=0.004))  # the back is met 2.79 mm off centre
    assert {f.where.rpartition(", ")[2] for f in failures(check_layout(small))} == {"back face"}
    flat = (0.023, 0.001)  # local_y is z: half-size across the bench first
    assert "TM1 0.5 mm outside" in lines(with_element(layout, "TM1", lambda e: replace(e, aperture_m=flat)))[0]
    narrow = with_element(layout, "TM1", lambda e: replace(e, aperture_m=(0.012, 0.023)))  # met at 12 mm
    excess = [f for f in check_layout(narrow) if f.element == "TM1" and f.check == "aperture"]
    assert [f.margin for f in excess] == pytest.approx([-1.5e-3] * 4, abs=1e-12)


def test_beams_that_do_not_meet(layout: OpticalLayout) -> None:
    """A mirror that turns by 1 mrad turns one beam of the interferometer by 2 mrad."""
    found = failures(check_layout(with_element(layout, "M6", lambda e: turned(e, 1e-3))))
    angles = {f.element: f.value for f in found if f.check == "angle"}
    assert angles == pytest.approx({"PD12A": 2e-3, "PD12B": 2e-3}, rel=1e-5)
    spots = [f for f in found if f.check == "overlap"]
    assert {f.element for f in spots} == {"PD12A", "PD12B"}
    assert "0.002 rad (0.115 deg)" in next(f.line for f in found if f.check == "angle")
    wide = replace(
        layout,
        elements=tuple(replace(e, recombination=Recombination(1e-2, 3e-3)) for e in layout.elements),
    )
    assert lines(with_element(wide, "M6", lambda e: turned(e, 1e-3))) == []


def test_paths_of_unlike_length(layout: OpticalLayout) -> None:
    longer = with_element(layout, "FIR", lambda e: replace(e, opl_offset_m=e.opl_offset_m + 2e-3))
    found = lines(longer)
    assert len(found) == 4
    assert "its optical paths differ by 2 mm" in found[0]
    free = tuple(replace(e, recombination=Recombination()) for e in longer.elements)
    assert lines(replace(longer, elements=free)) == []


def test_a_tilted_photodiode_is_as_good_as_any(layout: OpticalLayout) -> None:
    tilted = with_element(layout, "PD1A", lambda e: turned(e, 0.3))
    assert lines(tilted) == lines(tilted, "warning") == []


@pytest.mark.parametrize(
    ("name", "change", "fact", "hint"),
    [
        (
            "M2",
            lambda e: turned(e, np.pi),
            "step 9 (M2:R): the ray meets M2 from behind, 42.7 deg off",
            "turn its normal",
        ),
        ("M2", lambda e: shifted(e, (-0.5, 0, 0)), "m behind the ray", "ref_m"),
        ("M5", lambda e: replace(e, normal=(1.0, 0.0, 0.0)), "step 2 (M5:R): the ray runs parallel", "turn M5"),
    ],
)
def test_rays_that_are_lost(layout: OpticalLayout, name: str, change: Change, fact: str, hint: str) -> None:
    found = lines(with_element(layout, name, change))
    assert any(fact in line and hint in line for line in found), found


def test_a_mirror_does_not_transmit(layout: OpticalLayout) -> None:
    through = with_element(layout, "BS7", lambda e: replace(e, kind="mirror"))
    found = lines(through)
    assert len(found) == 4
    assert "step 3 (BS7:T): the beam goes through the mirror BS7; make BS7 a beamsplitter" in found[0]


def test_a_reference_point_far_from_its_surface(layout: OpticalLayout) -> None:
    off = with_element(layout, "W1", lambda e: shifted(replace(e, front_offset_m=0.033), (-0.03, 0.0, 0.0)))
    assert lines(off) == []  # the glass is where it was
    assert lines(off, "warning")[0].startswith("element W1: the reference point of W1 lies 27 mm off its surface")
    n = np.array(layout.elements[layout.index("M1")].normal)
    before = with_element(layout, "M1", lambda e: shifted(replace(e, front_offset_m=-0.02), tuple(0.02 * n)))
    assert [line for line in lines(before, "warning") if "M1 lies 20 mm off" in line]


def test_a_body_in_the_way(layout: OpticalLayout) -> None:
    """M3 moved into the straight beam from BS1 to BS2 that does not list it."""
    beam = (0.035, -0.095, 0.0)
    blocker = Element("M9", "mirror", beam, (0.0, 0.0, 1.0), grid=7, aperture_m=0.005)
    blocked = replace(layout, elements=(*layout.elements, blocker))
    found = lines(blocked, "warning")
    assert len(found) == 4  # all four measurement beams
    assert found[0].startswith("path PD1A meas, step 2 (BS1:T) to BS2:R: the beam passes through M9, ")
    assert lines(blocked) == []
    forgotten = tuple(
        replace(p, steps=tuple(s for s in p.steps if s.element != "BS7")) if p.photodiode == "PD1A" else p
        for p in layout.paths
    )
    assert any("passes through BS7" in line for line in lines(replace(layout, paths=forgotten), "warning"))


def test_everything_is_found_at_once(layout: OpticalLayout) -> None:
    wrong = with_element(layout, "M4", lambda e: shifted(e, (0.0, 0.0, 8e-3)))
    wrong = with_element(wrong, "M2", lambda e: turned(e, np.pi))
    wrong = with_element(wrong, "BS7", lambda e: replace(e, kind="mirror"))
    assert {f.check for f in failures(check_layout(wrong))} == {"aperture", "trace", "transmission"}


def segment(a: tuple[float, ...], b: tuple[float, ...], clearance: float = 0.0, **body: object) -> float | None:
    """How deep the segment passes inside a body of normal z at the origin, or None."""
    e = Element("B", "beamsplitter", (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), **body)  # type: ignore[arg-type]
    empty = OpticalLayout("", 1e-6, (e,), (), {}, ("x",), tolerances=Tolerances(clearance_m=clearance))
    met = list(obstructions(empty, np.array(a), np.array(b), ()))
    return met[0].depth_m if met else None


def test_segments_against_bodies() -> None:
    disc = {"aperture_m": 1.0, "thickness_m": 0.5}
    assert segment((0.4, 0, 2), (0.4, 0, -2), **disc) == pytest.approx(0.6)
    assert segment((1.1, 0, 2), (1.1, 0, -2), **disc) is None
    assert segment((1.1, 0, 2), (1.1, 0, -2), 0.2, **disc) == pytest.approx(0.1)
    assert segment((0.4, 0, 2), (0.4, 0, 0.1), **disc) is None  # ends above the front
    assert segment((-3, 0, -0.2), (3, 0, -0.2), **disc) == pytest.approx(1.0)  # through the rims
    assert segment((-3, 0, 0.2), (3, 0, 0.2), **disc) is None  # over it
    assert segment((-3, 1.5, -0.2), (3, 1.5, -0.2), **disc) is None  # past it
    plane: dict[str, Any] = {"aperture_m": (1.0, 0.5), "local_y": (0.0, 1.0, 0.0)}
    assert segment((0.9, 0.3, 1), (0.9, 0.3, -1), **plane) == pytest.approx(0.1)
    assert segment((0.3, 0.9, 1), (0.3, 0.9, -1), **plane) is None
    assert segment((0.9, 0.3, 1), (0.9, 0.3, 0.5), **plane) is None


def test_an_element_without_aperture_is_not_judged(layout: OpticalLayout) -> None:
    bare = replace(layout, elements=tuple(replace(e, aperture_m=None) for e in layout.elements))
    assert not {f.check for f in check_layout(bare)} & {"aperture", "obstruction"}


def project(folder: Path, layout_file: Path, old: str = "", new: str = "") -> list[str]:
    (folder / "optics.toml").write_text(
        layout_file.read_text().replace(old, new, 1) if old else layout_file.read_text()
    )
    (folder / "tedm.toml").write_text('title = "bench"\n')
    return ["-c", str(folder / "tedm.toml"), "-d", str(folder / "build")]


def run(monkeypatch: pytest.MonkeyPatch, *argv: str) -> object:
    monkeypatch.setattr(sys, "argv", ["tedm", *argv])
    with pytest.raises(SystemExit) as left:
        main()
    return left.value.code


def test_check_layout_prints_margins(
    tmp_path: Path, layout_file: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert not run(monkeypatch, "check-layout", *project(tmp_path, layout_file))
    out = capsys.readouterr().out
    assert "checks, 0 failed" in out
    w1 = next(line.split() for line in out.splitlines() if line.startswith("aperture") and " W1 " in line)
    assert w1[2:7] == ["15.21", "16.5", "1.295", "mm", "pass"]
    assert not run(monkeypatch, "check-layout", "--json", *project(tmp_path, layout_file))
    answer = json.loads(capsys.readouterr().out)
    assert answer["passed"]
    assert len(answer["findings"]) > 100
    assert "benches" not in out
    assert {name: len(elements) for name, elements in answer["benches"].items()} == {"bench": 22}


def test_check_layout_tells_of_several_benches(
    tmp_path: Path, layout_file: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert not run(monkeypatch, "check-layout", *project(tmp_path, layout_file.parent / "lisa_like" / "optics.toml"))
    line = capsys.readouterr().out.splitlines()[1]
    assert line.startswith("2 benches, each of which may move by itself: OB1 (FIT1, FIL1, W1, BST1,")
    assert line.endswith("BSR2, M2, PD2A, PD2B)")


def test_check_layout_and_build_optics_refuse_all_failures_at_once(
    tmp_path: Path, layout_file: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    options = project(tmp_path, layout_file, "aperture_m = 0.018", "aperture_m = 0.015")
    for command in ("check-layout", "build-optics"):
        assert run(monkeypatch, command, *options) == 5
        err = capsys.readouterr().err.splitlines()
        errors = [line for line in err if line.startswith("error: ")]
        assert len(errors) == len(err) - 1 > 3
        assert all("optics.toml: path PD1" in e and "mm outside its aperture" in e for e in errors)
        assert err[-1].startswith("hint: `tedm check-layout`")


def test_findings_know_their_margin() -> None:
    assert Finding("angle", "", "PD", 3e-5, 1e-4, "rad", True).margin == pytest.approx(7e-5)
    assert Finding("trace", "", "M1", None, None, "", False).margin is None


def test_a_lost_path_is_judged_up_to_where_it_is_lost(layout: OpticalLayout) -> None:
    lost = with_element(layout, "TM2", lambda e: turned(e, np.pi))
    found = [f for f in check_layout(lost) if f.where.startswith("path PD12A meas")]
    assert {f.element for f in found} >= {"BS1", "M4", "W2", "TM2"}
    assert "BS5" not in {f.element for f in found}
