"""`tedm explain` on the small sample: sums, loads, refusals, and what a program gets."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from tedm_cli.cli.commands import app
from tedm_cli.cli.printing.explain import explain_lines
from tedm_cli.config.project import Project
from tedm_cli.contracts import OPTICS
from tedm_cli.errors import InputError, UsageError
from tedm_cli.files.store import open_checked
from tedm_cli.stages.explain.read_outs import explain
from tedm_cli.stages.optics.build import build_optics

SMALL = Path(__file__).parents[2] / "sample_models" / "small" / "tedm.toml"


def explained(project: Project, *arguments: str) -> str:
    done = CliRunner().invoke(app, ["explain", *arguments, "-c", str(SMALL), "-d", str(project.build_dir)])
    assert done.exit_code == 0, done.output
    return done.output


def test_the_file_holds_the_factors_of_its_read_out(small: Project) -> None:
    with open_checked(small.build_dir / "optics.h5", OPTICS) as file:
        motion = file.array("/motion")
        for name in file.strings("/set/name"):
            gain, N = file.array(f"/gain/{name}"), file.array(f"/N/{name}")
            scale = (np.abs(gain) @ np.abs(motion)).max()
            assert np.abs(gain @ motion - N).max() < 1e-14 * scale
            assert np.abs(file.array(f"/inverse/{name}") @ file.array("/D") - N).max() < 1e-13 * scale
            parts = file.array(f"/N_rigid/{name}") + file.array(f"/N_distortion/{name}")
            assert np.abs(parts - N).max() < 1e-15 * scale
            assert np.abs(gain @ file.array("/rigid_motion") - file.array(f"/N_rigid/{name}")).max() < 1e-14 * scale


@pytest.mark.parametrize(
    "load", [{}, {"area": "STRUT_2"}, {"uniform": True}, {"uniform": True, "distortion_only": True}]
)
def test_shares_sum_to_all_of_it(small: Project, load: dict[str, object]) -> None:
    for set_name in "AB":
        for r in explain(small, None, set_name, **load).read_outs:  # type: ignore[arg-type]
            for part in (r.areas, r.motions, r.elements, r.beams):
                assert part.share.sum() == pytest.approx(1.0, abs=1e-9)


def test_the_uniform_load_is_the_sum_of_the_areas(small: Project) -> None:
    alone, together = explain(small), explain(small, uniform=True)
    for a, b in zip(alone.read_outs, together.read_outs, strict=True):
        assert b.value[0] == pytest.approx(a.total, rel=1e-9)
        assert len(a.value) == len(alone.areas) > len(b.value) == 1


def test_struts_move_the_bench_as_one(small: Project) -> None:
    """Clamped outside, each strut pushes the stiff bench along x: 98 % of what it reads is that, 2 % distortion."""
    r = explain(small, "TM1_x", area="STRUT_2").read_outs[0]
    assert r.rigid_share == pytest.approx(0.982, abs=5e-3)
    left = explain(small, "TM1_x", area="STRUT_2", distortion_only=True).read_outs[0]
    assert abs(left.value[0]) == pytest.approx(r.distortion_size, rel=1e-9)
    assert left.rigid_size == 0


def test_json_is_what_the_tables_print(small: Project) -> None:
    found = json.loads(explained(small, "TM2_eta", "--set", "B", "--top", "3", "--json"))
    assert (found["set"], found["load"], len(found["read_outs"])) == ("B", "every area", 1)
    assert found["condition"] == pytest.approx(2.64, abs=5e-3)
    (r,) = found["read_outs"]
    assert (r["label"], r["unit"]) == ("TM2_eta", "rad/K")
    assert r["rigid"]["share"] + r["distortion"]["share"] == pytest.approx(1.0, abs=1e-12)
    with open_checked(small.build_dir / "optics.h5", OPTICS) as file:
        row = file.array("/N/B")[file.strings("/label/read_out").index("TM2_eta")]
        names = file.strings("/area/name")
    assert r["sum"] == pytest.approx(row.sum(), rel=1e-9)
    assert [a["name"] for a in r["areas"]] == [names[i] for i in np.argsort(-np.abs(row))[:3]]
    assert [a["value"] for a in r["areas"]] == pytest.approx(sorted(row, key=abs, reverse=True)[:3], rel=1e-9)
    for kind in ("elements", "motions", "beams"):
        sizes = [abs(x["share"]) for x in r[kind]]
        assert sizes == sorted(sizes, reverse=True)
        assert 0 < len(sizes) <= 3
    (pair,) = found["sets"]
    assert (pair["first"], pair["second"], pair["same"]) == ("A", "B", True)
    text = explained(small, "TM2_eta", "--set", "B", "--top", "3")
    assert all(a["name"] in text for a in r["areas"])
    assert "for thermal distortion B adds nothing to A" in text


def test_names_that_there_are_not(small: Project) -> None:
    with pytest.raises(UsageError, match="no read-out is called 'TM1_z'") as caught:
        explain(small, "TM1_z")
    assert caught.value.hint == "did you mean TM1_x?"
    with pytest.raises(UsageError, match="no set is called 'Q'") as caught:
        explain(small, set_name="Q")
    assert caught.value.hint == "there are A, B"
    with pytest.raises(UsageError, match="no area is called 'STRUT_9'"):
        explain(small, area="STRUT_9")
    with pytest.raises(UsageError, match="different loads"):
        explain(small, area="STRUT_1", uniform=True)


def other_optics(small: Project, folder: Path, change: tuple[str, str] = ("", ""), more: str = "") -> Project:
    """The small sample with another layout file, its optics built from the same distortion."""
    text = small.required_optics().read_text(encoding="utf-8")
    assert change[0] in text
    layout = folder / "optics.toml"
    layout.write_text(text.replace(*change) + more, encoding="utf-8")
    (folder / "distortion.h5").write_bytes((small.build_dir / "distortion.h5").read_bytes())
    return replace(small, optics=layout, build_dir=folder)


def test_curvature_is_reported_with_what_the_second_set_adds(small: Project, tmp_path: Path) -> None:
    curved = 'photodiode = "PD1B"\nbeam = "meas"\n'
    project = other_optics(small, tmp_path, (curved, curved + "wavefront_radius_m = 0.5\n"))
    build_optics(project, None)
    (c,) = explain(project).comparisons
    assert c.relative.max() > 1e-4
    text = "\n".join(explain_lines(explain(project), 1))
    assert "sets A and B differ" in text
    assert "weight of A" in text


GLASS = 'dn_dT_1_K = 8.3e-6\nexpansion_1_K = 5.2e-7\narea = "OB_BENCH_PLUS_Y"\n'


def test_plates_are_a_part_beside_the_bench_and_its_distortion(small: Project, tmp_path: Path) -> None:
    """All sums of shares, what the distortion was before, and what the thickness and the index do, by name."""
    splitter = 'name = "BS4"\n'
    build_optics(project := other_optics(small, tmp_path, (splitter, splitter + GLASS)), None)
    for kwargs in ({}, {"area": "OB_BENCH_PLUS_Y"}, {"uniform": True}):
        for r, before in zip(explain(project, **kwargs).read_outs, explain(small, **kwargs).read_outs, strict=True):
            assert not before.beside
            (plates,) = r.beside
            for s in (r.motions, r.elements, r.beams):
                assert s.share.sum() == pytest.approx(1.0, abs=1e-9)
            assert r.distortion_size == pytest.approx(before.distortion_size, rel=1e-9)
            assert r.rigid_size == pytest.approx(before.rigid_size, rel=1e-12)
            own = dict(zip(r.elements.label, r.elements.size, strict=True))
            assert own["BS4 glass"] == pytest.approx(plates.size, rel=1e-12)
            share = dict(zip(r.motions.label, r.motions.share, strict=True))
            assert share["BS4_index"] + share["BS4_thickness"] == pytest.approx(plates.share, abs=1e-12)
    x = explain(project, "TM1_x", area="OB_BENCH_PLUS_Y").read_outs[0]
    assert x.beside[0].name == "plates"
    assert x.beside[0].share > 0.9
    alone = explain(project, "TM1_x", distortion_only=True).read_outs[0]
    assert not alone.beside
    assert alone.size == pytest.approx(explain(small, "TM1_x", distortion_only=True).read_outs[0].size, rel=1e-12)
    text = "\n".join(explain_lines(explain(project), 40))
    assert "plates %" in text
    assert "BS4 glass" in text
    assert "BS4_thickness" in text
    assert "plates" not in "\n".join(explain_lines(explain(small), 40))


def test_a_growing_test_mass_is_an_element_like_any(small: Project, tmp_path: Path) -> None:
    entry = '\n[[test_mass_expansion]]\ntest_mass = "TM1"\nexpansion_per_K = 1.65e-5\narea = "{area}"\n'
    build_optics(project := other_optics(small, tmp_path, more=entry.format(area="IS1_EH_DOWN")), None)
    r, before = (explain(p, "TM1_x", area="IS1_EH_DOWN").read_outs[0] for p in (project, small))
    assert r.value[0] - before.value[0] == pytest.approx(1.65e-5 * 0.023, rel=1e-9)
    assert r.rigid_size == pytest.approx(before.rigid_size, rel=1e-12)
    share = dict(zip(r.elements.label, r.elements.share, strict=True))
    assert share["TM1"] == pytest.approx(1.65e-5 * 0.023 / r.value[0], rel=1e-9)
    with pytest.raises(InputError, match="'IS1_EH', which does not exist"):
        build_optics(other_optics(small, tmp_path, more=entry.format(area="IS1_EH")), None)
