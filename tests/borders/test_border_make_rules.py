"""Names of files on their way to Make: rules that build, or one refusal. Nothing is ever run."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from border_tools import CONFIGS, ROOT, SMALL, Project, replace, untouched
from shipped_cases import cases_of_areas

from tedm_cli.control_characters import control_fact

make = pytest.mark.skipif(shutil.which("make") is None, reason="needs make")

#: names that Make or a shell would read in their own ways
HOSTILE = [
    "a b.bdf", "a\tb.bdf", "a\nb.bdf", "a\rb.bdf", "a b.bdf", "$(shell touch pwned).bdf", "${shell touch pwned}.bdf",
    "$$(touch pwned).bdf", "`touch pwned`.bdf", "a#b.bdf", "a%b.bdf", "a:b.bdf", "a;touch pwned;.bdf", "a|b.bdf",
    "a&b.bdf", "a=b.bdf", "a*b.bdf", "a?b.bdf", "a[b].bdf", "a\\b.bdf", "a'b.bdf", 'a"b.bdf', "a(b).bdf", "a<b>.bdf",
    "a!b.bdf", "~root.bdf", "a{b,c}.bdf", "a\x1b[2Jb.bdf", "a‮b.bdf", "a\u2028b.bdf", "a\x7fb.bdf",
]  # fmt: skip
PLAIN = ["Änderung-7_ü.bdf", "模型.bdf", "a,b+c@d^e.bdf", "..a..bdf"]
KEYS = {"bdf": "model.bdf", "areas_csv": "model.areas_csv", "deck": "model.deck", "op2": "model.op2"}


@pytest.fixture
def fresh(tmp_path: Path) -> Project:
    """The small sample, not yet ingested."""
    folder = tmp_path / "project"
    folder.mkdir()
    for name in ("unit_loads.bdf", "unit_loads.op2", "model.toml", "ltp_small.bdf", "ltp_small_areas.csv"):
        shutil.copy(SMALL / name, folder)
    shutil.copy(CONFIGS / "optics.toml", folder)
    (folder / "cases.toml").write_text(cases_of_areas())
    (folder / "tedm.toml").write_text('title = "small sample"\n')
    return Project(folder)


def quoted(text: str) -> str:
    """As a basic string of TOML."""
    return '"' + "".join(c if c.isalnum() or c in "._-{}/" else f"\\U{ord(c):08x}" for c in text) + '"'


def solved_by_tedm(project: Project) -> None:
    """Deck and results are made here, from the model and its areas."""
    replace(project.model, '"unit_loads.bdf"', '"{build_dir}/unit_loads.bdf"')
    replace(project.model, '"unit_loads.op2"', '"{build_dir}/unit_loads.op2"')


def run_make(project: Project, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Make in an environment that is there already."""
    venv = project.folder.parent / "venv"
    (venv / "bin").mkdir(parents=True, exist_ok=True)
    script = venv / "bin" / "tedm"
    script.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m tedm_cli.cli "$@"\n')
    script.chmod(0o755)
    (venv / ".tedm-installed").touch()
    environment = {k: v for k, v in os.environ.items() if not k.startswith(("MAKE", "MFLAGS"))}
    variables = [f"CONFIGS={project.folder}", f"BUILD={project.build}", f"VENV={venv}"]
    return subprocess.run(
        ["make", "--no-print-directory", *arguments, *variables],
        cwd=ROOT,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.parametrize("name", HOSTILE)
@pytest.mark.parametrize("key", KEYS)
def test_a_name_that_make_cannot_take(fresh: Project, name: str, key: str) -> None:
    value = f"[{quoted(name)}]" if key == "op2" else quoted(name)
    if key == "bdf":
        solved_by_tedm(fresh)
    lines = fresh.model.read_text().splitlines(keepends=True)
    place = next(i for i, line in enumerate(lines) if line.startswith(f"{key} = "))
    fresh.model.write_text("".join([*lines[:place], f"{key} = {value}\n", *lines[place + 1 :]]))
    with untouched(fresh.folder):
        if control_fact(name, "\t\n"):  # no configuration may hold these
            fresh.run("make-rules").refused(3, KEYS[key], "holds the control character", hint="delete the character")
        else:
            fresh.run("make-rules").refused(3, KEYS[key], "which Make cannot take", hint="the commands by themselves")


@make
@pytest.mark.parametrize("name", ["$(shell touch pwned).bdf", "a b.bdf", "`touch pwned`.bdf", "a;touch pwned;.bdf"])
def test_make_runs_nothing_and_says_why(fresh: Project, name: str) -> None:
    (fresh.folder / "ltp_small.bdf").rename(fresh.folder / name)
    solved_by_tedm(fresh)
    replace(fresh.model, '"ltp_small.bdf"', quoted(name))
    for arguments in (["-n", "all"], ["all"]):
        done = run_make(fresh, *arguments)
        assert done.returncode == 2
        assert "error: " in done.stderr
        assert "which Make cannot take" in done.stderr
        assert not list(fresh.folder.parent.rglob("pwned"))
        assert not (ROOT / "pwned").exists()
    assert not fresh.build.exists()


@make
def test_plain_names_build_and_are_watched(fresh: Project) -> None:
    """Names of any script are prerequisites: what is up to date stays, what is touched is made again."""
    bdf, areas, deck, op2 = PLAIN
    for old, name in (
        ("ltp_small.bdf", bdf),
        ("ltp_small_areas.csv", areas),
        ("unit_loads.bdf", deck),
        ("unit_loads.op2", op2),
    ):
        (fresh.folder / old).rename(fresh.folder / name)
        replace(fresh.model, f'"{old}"', f'"{name}"')
    target = str(fresh.build / "unit_loads.h5")
    first = run_make(fresh, target)
    assert first.returncode == 0, first.stderr
    assert "ingest" in first.stdout
    assert "ingest" not in run_make(fresh, "-n", target).stdout
    for name in (areas, deck, op2):
        later = (fresh.build / "unit_loads.h5").stat().st_mtime + 5
        os.utime(fresh.folder / name, (later, later))
        assert "ingest" in run_make(fresh, "-n", target).stdout
        os.utime(fresh.folder / name, (later - 3600, later - 3600))


@make
def test_of_a_layout_the_unit_loads_watch_the_symmetry_plane_alone(fresh: Project) -> None:
    made, layout = fresh.build / "unit_loads.h5", fresh.folder / "optics.toml"
    assert run_make(fresh, str(fresh.build / "symmetry_plane")).returncode == 0
    made.touch()

    def commands() -> str:
        earlier = layout.stat().st_mtime - 5
        os.utime(fresh.build / "rules.mk", (earlier, earlier))
        done = run_make(fresh, "-n", str(made))
        assert done.returncode == 0, done.stderr
        assert "make-rules" in done.stdout
        return done.stdout

    replace(layout, "wavelength_m = 1.064e-6", "wavelength_m = 1.063e-6")
    replace(layout, "origin_m = [0.0, 0.0, 0.0]", "origin_m = [0.5, 0.0, 0.5]")  # in the plane
    assert "ingest" not in commands()
    replace(layout, "origin_m = [0.5, 0.0, 0.5]", "origin_m = [0.5, 1e-5, 0.5]")
    assert "ingest" in commands()


@make
def test_of_compensation_masses_the_unit_loads_watch_the_ties_alone(fresh: Project) -> None:
    """The whole CSV is what the field is made of; no other number of it is in the unit loads."""
    made, blocks = fresh.build / "unit_loads.h5", fresh.folder / "blocks.csv"
    replace(fresh.model, "[gravity]\n", '[gravity]\ncompensation_masses = "blocks.csv"\n')
    head = "name,x_m,y_m,z_m,size_x_m,size_y_m,size_z_m,rotation_x_rad,rotation_y_rad,rotation_z_rad,mass_kg,grid\n"
    blocks.write_text(head + "CM1,0,0,0.1,0.02,0.02,0.02,0,0,0,0.1,\n")
    assert run_make(fresh, str(fresh.build / "ties")).returncode == 0
    made.touch()

    def commands(target: Path) -> str:
        done = run_make(fresh, "-n", str(target))
        assert done.returncode == 0, done.stderr
        return done.stdout

    def change(old: str, new: str) -> None:
        replace(blocks, old, new)
        earlier = blocks.stat().st_mtime - 5
        os.utime(fresh.build / "rules.mk", (earlier, earlier))

    assert "make-rules" not in commands(made)
    change(",0.1,\n", ",0.2,\n")
    assert "make-rules" in commands(made)
    assert "ingest" not in commands(made)
    (fresh.build / "sensitivity.h5").touch()
    change(",0.2,\n", ",0.2,850001\n")
    found = commands(fresh.build / "sensitivity.h5")
    assert found.index("make-rules") < found.index("ingest") < found.index("build-sensitivity")
    blocks.write_text(head + "CM1,0,0,0.1,0.02,0.02,0.02,0,0,0,0.1,x\n")
    change(",x\n", ",y\n")
    done = run_make(fresh, "-n", str(made))
    assert done.returncode == 2
    assert "blocks.csv:2: grid: 'y' names no grids" in done.stderr


@make
def test_a_note_beside_the_configuration(fresh: Project) -> None:
    """A file that the project does not name is nothing to Make, whatever its name."""
    (fresh.folder / "my notes $(shell touch pwned).toml").write_text("")
    done = run_make(fresh, "-n", "all")
    assert done.returncode == 0, done.stderr
    assert not (ROOT / "pwned").exists()


@make
def test_a_configuration_file_that_was_renamed(fresh: Project) -> None:
    assert run_make(fresh, "-n", "all").returncode == 0
    (fresh.folder / "optics.toml").rename(fresh.folder / "bench.toml")
    (fresh.folder / "tedm.toml").write_text('title = "small sample"\noptics = "bench.toml"\n')
    earlier = (fresh.folder / "tedm.toml").stat().st_mtime - 5
    os.utime(fresh.build / "rules.mk", (earlier, earlier))
    done = run_make(fresh, "-n", "all")
    assert done.returncode == 0, done.stderr
    assert "bench.toml" in (fresh.build / "rules.mk").read_text()


@make
@pytest.mark.parametrize("variable", ["CONFIGS", "BUILD"])
def test_folders_with_blanks_are_refused_by_make(fresh: Project, variable: str) -> None:
    done = subprocess.run(
        ["make", "-n", "all", f"{variable}=a b"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 2
    assert f"{variable} = 'a b': Make takes no names with blanks" in done.stderr


@make
def test_a_solver_with_quotes(fresh: Project) -> None:
    """The command comes to the shell as one word."""
    solved_by_tedm(fresh)
    done = run_make(fresh, "-n", "stages", "NASTRAN=sh -c 'exec x' {deck}")
    assert "--run 'sh -c '\\''exec x'\\'' {deck}'" in done.stdout, done.stderr


@make
def test_series_are_run_without_and_with_the_loop(fresh: Project) -> None:
    """By what Make would run: each once, before the figures; with one test mass there is no loop."""
    (fresh.folder / "warm.csv").write_text("time_s,all\n0,1\n1,2\n")
    with open(fresh.folder / "cases.toml", "a") as stream:
        stream.write('\n[[series]]\nname = "warm"\nfile = "warm.csv"\nremove = "mean"\n')
    done = run_make(fresh, "-n", "stages")
    assert done.returncode == 0, done.stderr
    commands = [line.split()[1:4] for line in done.stdout.splitlines() if "/bin/tedm " in line]
    assert commands.count(["run-series", "warm", "-c"]) == commands.count(["simulate", "--series", "warm"]) == 1
    assert [words[0] for words in commands][-3:] == ["plot", "report", "view"]
    text = fresh.model.read_text()
    second = text.index('[[test_mass]]\nname = "TM2"')
    gravity = text[text.index("[gravity]", second) :].replace(', TM2 = ["IS2"]', "")
    fresh.model.write_text(text[:second] + gravity.replace('name = "lpf"', 'name = "lpf"\napplies_to = "single"'))
    done = run_make(fresh, "-n", "stages")
    assert "run-series warm" in done.stdout
    assert "--series" not in done.stdout
    (fresh.folder / "warm.csv").rename(fresh.folder / "hot.csv")
    done = run_make(fresh, "-n", "stages")
    assert done.returncode != 0
    assert "warm.csv" in done.stderr


@make
@pytest.mark.parametrize(
    ("configs", "script", "always", "model"),
    [
        ("configs", "ltp_like.py", "", "ltp.bdf"),
        ("configs/spacecraft", "ltp_like.py", "--spacecraft ", "ltp_spacecraft.bdf"),
        ("configs/lisa_like", "lisa_like.py", "", "lisa.bdf"),
    ],
    ids=["ltp", "spacecraft", "lisa"],
)
def test_each_sample_is_meshed_by_its_own_script(
    tmp_path: Path, configs: str, script: str, always: str, model: str
) -> None:
    """With its own layout; with its own element size and mount where Make is given none."""
    folder = tmp_path / "project" / "configs"
    shutil.copytree(ROOT / configs, folder)
    for name in ("optics.toml", "dynamics.toml"):  # of a sample that shares them with another
        shutil.copy(CONFIGS / name, folder.parent)
    layout = folder.parent / "optics.toml" if always else folder / "optics.toml"
    project = Project(folder)
    for arguments, options in (
        ((), ""),
        (("ELEMENT_SIZE_MM=7",), "--element-size-mm 7 "),
        (("ELEMENT_SIZE_MM=7", "MODEL_ARGUMENTS=--mount pinned"), "--element-size-mm 7 --mount pinned "),
    ):
        done = run_make(project, "-n", "all", *arguments)
        assert done.returncode == 0, done.stderr
        meshed = [" ".join(line.split()) for line in done.stdout.splitlines() if "sample_models/" in line]
        assert len(meshed) == 1
        where = meshed[0].replace(f"{folder}/../", f"{folder.parent}/")
        assert where.endswith(f"sample_models/{script} {always}{options}--layout {layout} -o {project.build / model}")
