"""Any name that report and prints use, and what it stands for: found in the files that are there."""

from __future__ import annotations

import contextlib
import difflib
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.config.cases import load_cases
from tedm_cli.config.halves import halves_of
from tedm_cli.config.model.file import load_model
from tedm_cli.config.project import Project
from tedm_cli.contracts import KINDS, OPTICS, SENSITIVITY
from tedm_cli.contracts.spec import FileKind
from tedm_cli.errors import UsageError
from tedm_cli.files.build_folder import (
    DISTORTION_FILE,
    OPTICS_FILE,
    SENSITIVITY_FILE,
    require_configuration,
    require_same_input,
)
from tedm_cli.files.store import Reader, open_checked
from tedm_cli.noise.differences import terms
from tedm_cli.noise.effects import Effects
from tedm_cli.results.adjoint.within import CaseGradients, case_gradients
from tedm_cli.results.areas import read_areas
from tedm_cli.results.cases.effects import read_effects
from tedm_cli.results.explained import Told, also, without_empty
from tedm_cli.results.gravity.self_gravity import read_self_gravity
from tedm_cli.results.optics import ReadOuts, read_read_outs
from tedm_cli.results.outputs import read_outputs
from tedm_cli.stages.common import known_name
from tedm_cli.stages.explain.areas import (
    Rows,
    explain_area,
    explain_difference,
    explain_effect,
    explain_element,
    explain_gradient,
    explain_group,
)
from tedm_cli.stages.explain.grids import explain_grids
from tedm_cli.stages.explain.judged import (
    explain_case,
    explain_loop_noise,
    explain_loop_output,
    explain_requirement,
    loop_noise_names,
    loop_output_names,
    requirement_names,
)
from tedm_cli.stages.explain.masses import explain_block, explain_subsystem, explain_test_mass
from tedm_cli.stages.explain.read_outs import Explanation, explain
from tedm_cli.stages.explain.self_gravity import explain_self_gravity

_READ_OUT = "read-out"
_READ_OUT_NAME = re.compile(r"(?!.*_(?:a|omegadot)_).+_(?:x|y|z|theta|eta|phi)")
_NEAR = 5  # names that are offered in place of one that there is not


@dataclass(frozen=True)
class Load:
    """What is asked of read-outs: a set, one area or all at once, without the rigid motion of the benches."""

    set_name: str | None = None
    area: str | None = None
    uniform: bool = False
    distortion_only: bool = False

    def given(self) -> str:
        """The first option that is given; empty where none is."""
        words = {
            "--set": self.set_name is not None,
            "--area": self.area is not None,
            "--uniform": self.uniform,
            "--distortion": self.distortion_only,
        }
        return next((word for word, is_given in words.items() if is_given), "")


@dataclass(frozen=True, eq=False)
class _Files:
    """The files of outputs that the project has and that are there, open, and what they say.

    `rows` are with the `effects` of the user's own, whose rows are in the same order.
    """

    project: Project
    first: Reader
    gravity: Reader | None
    read_outs: ReadOuts | None
    rows: Rows
    effects: Effects
    gradients: CaseGradients | None
    missing: tuple[Path, ...]


Found = Explanation | Told
Teller = Callable[[str], Found]


def explain_name(project: Project, name: str | None, load: Load) -> list[Found]:
    """What a name stands for; without one, every read-out and every output of the self-gravity that is there.

    Raises
    ------
    UsageError : nothing is called so (the nearest names are told), or the options are of read-outs and it is none.
    ConfigError : it is a read-out's name, and the project has no optics.
    InputError : no file of outputs is there, or one that is stale.
    """
    with _open(project) as files:
        sorts = _sorts(files, load)
        if name is None:
            if load.given() and files.read_outs is None:
                raise project.lacks_optics()
            read_outs = [] if files.read_outs is None else [_read_out(project, None, load)]
            told = [] if load.given() or files.gravity is None else read_self_gravity(files.gravity).label
            return [*read_outs, *(_gravity(files, label) for label in told)]
        found = [(sort, tell) for sort, names, tell in sorts if name in names]
        if not found and (pair := terms(name)) is not None and all(label in files.rows for label in pair):
            found = [("difference", lambda label: _difference(files, label))]
        if not found:
            if project.optics is None and _READ_OUT_NAME.fullmatch(name):
                raise project.lacks_optics()
            raise _unknown(name, [known for _, names, _ in sorts for known in names], files.missing)
        (sort, tell), *others = found
        if sort != _READ_OUT and load.given():
            fact = f"{load.given()} is for read-outs, and {name} is a {sort}"
            raise UsageError(fact, hint=f"tedm explain {name}")
        done = tell(name)
        return [also(without_empty(done), [other for other, _ in others]) if isinstance(done, Told) else done]


def explain_places(project: Project, name: str | None, load: Load) -> Told:
    """Where on the model an output feels temperatures: `explain --grids`.

    Raises
    ------
    UsageError : no name, or not that of an output; options of read-outs that ask for something else.
    InputError : as `explain_grids`.
    """
    if name is None:
        raise UsageError("--grids takes the name of an output", hint="tedm explain TM1_a_x --grids")
    given = replace(load, set_name=None).given()
    if given:
        raise UsageError(f"{given} and --grids ask for different things", hint="leave one of them away")
    with _open(project) as files:
        r, label = files.read_outs, name
        if r is not None and name in (*r.label, *r.names):
            own, chosen = _of_set(load, name, r)
            label = f"{chosen.set_name or r.sets[0]}_{own}"
        elif load.set_name is not None:
            raise UsageError(f"--set is for read-outs, and {name} is none", hint=f"tedm explain {name} --grids")
        outputs = list(files.rows)
        parts = (label,) if label in outputs else terms(label) or (label,)
        units = [files.rows[known_name("output", one, outputs)][0] for one in parts]
        if len(set(units)) > 1:
            raise UsageError(f"{label} is a difference of {' and '.join(units)}")
    return explain_grids(project, label)


def known_names(project: Project) -> list[str]:
    """All names that can be asked for."""
    with _open(project) as files:
        return list(dict.fromkeys(name for _, names, _ in _sorts(files, Load()) for name in names))


def _sorts(files: _Files, load: Load) -> list[tuple[str, Sequence[str], Teller]]:
    """All names by sort, and who tells of them; of a name in two sorts the first is told."""
    project, gravity, r, rows = files.project, files.gravity, files.read_outs, files.rows
    areas = read_areas(files.first)
    sorts: list[tuple[str, Sequence[str], Teller]] = []
    if r is not None:
        sorts.append((_READ_OUT, [*r.label, *r.names], lambda n: _read_out(project, *_of_set(load, n, r))))
    if gravity is not None:
        sorts.append(("self-gravity output", read_self_gravity(gravity).label, lambda n: _gravity(files, n)))
    sorts += [
        ("requirement", requirement_names(project), lambda n: explain_requirement(project, n)),
        ("thermal area", areas.name.tolist(), lambda n: explain_area(n, areas, rows)),
        ("gradient within areas", _gradient_names(files), lambda n: _gradient(files, n)),
        ("group of thermal areas", sorted(set(areas.group.tolist())), lambda n: explain_group(n, areas, rows)),
    ]
    if gravity is not None:
        masses, blocks = SENSITIVITY.TEST_MASS_NAME, SENSITIVITY.COMPENSATION_NAME
        subsystems = list(load_model(project.model)[1].gravity.subsystems)
        sorts += [
            ("test mass", gravity.strings(masses), lambda n: explain_test_mass(n, gravity, areas, rows)),
            ("compensation mass", gravity.strings(blocks), lambda n: explain_block(n, gravity)),
            ("subsystem", subsystems, lambda n: explain_subsystem(n, project, gravity)),
        ]
    if r is not None:
        sorts.append(("optical element", r.element, lambda n: explain_element(n, r, ~areas.gradient)))
    sorts.append(("effect of your own", files.effects.names, lambda n: explain_effect(n, files.effects, rows, areas)))
    return [
        *sorts,
        ("output of the drag-free loop", loop_output_names(project), lambda n: explain_loop_output(project, n)),
        ("noise of the drag-free loop", loop_noise_names(project), lambda n: explain_loop_noise(project, n)),
        ("case", load_cases(project.cases)[1].ids, lambda n: explain_case(project, n)),
    ]


def _read_out(project: Project, name: str | None, load: Load) -> Explanation:
    return explain(project, name, load.set_name, load.area, uniform=load.uniform, distortion_only=load.distortion_only)


def _of_set(load: Load, name: str, r: ReadOuts) -> tuple[str, Load]:
    """A read-out, and the set that a name like A_TM1_x says; `UsageError` where another one is asked for."""
    if name in r.label:
        return name, load
    chosen, row = divmod(r.names.index(name), len(r.label))
    if load.set_name not in (None, r.sets[chosen]):
        fact = f"{name} is of set {r.sets[chosen]}, and --set asks for {load.set_name}"
        raise UsageError(fact, hint="leave --set away")
    return r.label[row], replace(load, set_name=r.sets[chosen])


def _gravity(files: _Files, name: str) -> Told:
    assert files.gravity is not None
    terms = ((1.0, name),)
    return without_empty(explain_self_gravity(files.project, files.gravity, name, terms, _own(files, terms)))


def _own(files: _Files, terms: Sequence[tuple[float, str]]) -> dict[str, FloatArray]:
    """What effects of the user's own are in a sum of outputs, [k] by their names as parts; none that is not in it."""
    place = list(files.rows)
    rows = sum(f * files.effects.rows[:, place.index(name)] for f, name in terms)
    return {n: row for n, row in zip(files.effects.part_names, np.asarray(rows), strict=True) if row.any()}


def _gradient_names(files: _Files) -> list[str]:
    found = files.gradients
    return [] if found is None else [name for of in found.tables.values() for name in of.areas.name.tolist()]


def _gradient(files: _Files, name: str) -> Told:
    assert files.gradients is not None
    found = files.gradients
    number, of = next((n, of) for n, of in found.tables.items() if name in of.areas.name.tolist())
    cases = [case_id for case_id in found.config.ids if number in found.config.within(case_id)]
    return explain_gradient(name, of, cases, {label: unit for label, (unit, _) in files.rows.items()})


def _difference(files: _Files, label: str) -> Told:
    """Of two outputs of one quantity; `UsageError` for others."""
    first, second = label.split("-")
    pair = ((1.0, first), (-1.0, second))
    units = [files.rows[name][0] for _, name in pair]
    if units[0] != units[1]:
        raise UsageError(f"{label} is a difference of {units[0]} and {units[1]}")
    gravity = [] if files.gravity is None else read_self_gravity(files.gravity).label
    if files.gravity is not None and first in gravity and second in gravity:
        return explain_self_gravity(files.project, files.gravity, label, pair, _own(files, pair))
    r = files.read_outs
    if r is None or first in gravity or second in gravity:
        raise UsageError(f"{label} is a difference of self-gravity and a read-out")
    by_part = {f"{s}_{n}": terms for s in r.sets for n, terms in zip(r.label, r.by_part(s), strict=True)}
    parts = dict(zip(r.part_names, sum(f * by_part[name] for f, name in pair), strict=True)) | _own(files, pair)
    return explain_difference(label, pair, files.rows, parts, read_areas(files.first))


def _unknown(name: str, known: Sequence[str], missing: Sequence[Path]) -> UsageError:
    """That nothing is called so, and what may be meant."""
    folded = {k.casefold(): k for k in known}
    near = difflib.get_close_matches(name.casefold(), folded, n=_NEAR, cutoff=0.5)
    hint = f"did you mean {', '.join(folded[n] for n in near)}?" if near else (
        "it takes outputs, requirements, areas, groups, test masses, optical elements and effects; without a name, all"
        " outputs"
    )  # fmt: skip
    more = "".join(f"; {path} is not there, and may have it (`{KINDS[path.stem].made_by}`)" for path in missing)
    return UsageError(f"nothing is called {name!r}", hint=hint + more)


@contextlib.contextmanager
def _open(project: Project) -> Iterator[_Files]:
    """The files of the halves that the project has, as far as they are there; `InputError` where none is."""
    halves = halves_of(project, load_model(project.model)[1])
    wanted: list[tuple[Path, FileKind, Path]] = [
        *([(project.build_dir / SENSITIVITY_FILE, SENSITIVITY, project.model)] if halves.gravity else []),
        *([(project.build_dir / OPTICS_FILE, OPTICS, project.optics)] if project.optics is not None else []),
    ]
    there = [one for one in wanted if one[0].exists()] or wanted[:1]
    with contextlib.ExitStack() as stack:
        files = []
        for path, kind, config in there:
            files.append(stack.enter_context(open_checked(path, kind)))
            require_configuration(files[-1], config)
        require_same_input(DISTORTION_FILE, *files)
        gravity = next((f for f in files if f.kind is SENSITIVITY), None)
        read_out = next((f for f in files if f.kind is OPTICS), None)
        read_outs = None if read_out is None else read_read_outs(read_out)
        missing = [path for path, *_ in wanted if not path.exists()]
        rows, model, areas = _rows(gravity, read_outs), load_model(project.model)[1], read_areas(files[0])
        units = [unit for unit, _ in rows.values()]
        effects = read_effects(project, model, list(rows), units, areas, partly=bool(missing))
        added = {n: (u, row + own) for (n, (u, row)), own in zip(rows.items(), effects.total, strict=True)}
        of_cases = load_cases(project.cases)[1]
        gradients = None
        if of_cases.needs_adjoint and not missing:
            gradients = case_gradients(project, of_cases, read_outputs(project))
        if gradients is not None and gradients.path is not None and not gradients.path.exists():
            missing.append(gradients.path)
        yield _Files(project, files[0], gravity, read_outs, added, effects, gradients, tuple(missing))


def _rows(gravity: Reader | None, r: ReadOuts | None) -> Rows:
    rows: Rows = {}
    if gravity is not None:
        s = read_self_gravity(gravity)
        rows |= {n: (u.removesuffix("/K"), row) for n, u, row in zip(s.label, s.unit, s.S, strict=True)}
    if r is not None:
        for name in r.sets:
            rows |= {f"{name}_{n}": (u, row) for n, u, row in zip(r.label, r.unit, r.N[name], strict=True)}
    return rows
