"""The command line: load the configuration, call one stage, say what came out. All physics is in the configuration.

Stages are imported inside the commands, so that `tedm --help` does not wait for SciPy, pyNastran or matplotlib.
"""

from __future__ import annotations

import json
import os
import sys
import traceback
from pathlib import Path
from typing import Annotated, Any, NoReturn

import typer

from tedm_cli import __version__
from tedm_cli.errors import TedmError, UsageError

app = typer.Typer(
    name="tedm",
    help="Thermo-elastic distortion modelling for drag-free satellites: from a Nastran model and its unit-load results"
    " to self-gravity and read-out noise, judged against requirements.",
    epilog="Stages in order: write-deck, solve, ingest, build-distortion, build-sensitivity, build-optics, run-case,"
    " plot, report. `make all` runs them all.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)

Config = Annotated[Path, typer.Option("-c", "--config", help="Project file; it names the other configuration files.")]
BuildDir = Annotated[Path, typer.Option("-d", "--build-dir", help="Folder of the files between stages.")]
Output = Annotated[Path | None, typer.Option("-o", "--output", help="Write here instead of into the build folder.")]
Quiet = Annotated[bool, typer.Option("-q", "--quiet", help="Print errors only.")]
Verbose = Annotated[int, typer.Option("-v", "--verbose", count=True, help="Say more on stderr; -vv adds tracebacks.")]
Json = Annotated[bool, typer.Option("--json", help="Print the answer as JSON.")]

DEFAULT_CONFIG = Path("configs/tedm.toml")
DEFAULT_BUILD = Path("build")

_INTERRUPTED = 130
_TyperUsageError: Any = typer.BadParameter.__base__  # unknown options and commands, missing arguments

_verbosity = 0


def main() -> None:
    """Run the command; turn expected failures into one message and an exit code (see `tedm_cli.errors`)."""
    try:
        # Typer's own handling of errors is off: it answers in another form, and says nothing of an interrupt.
        code = app(sys.argv[1:] or ["--help"], prog_name="tedm", standalone_mode=False)
        sys.stdout.flush()
        if code == _INTERRUPTED:
            raise KeyboardInterrupt
        sys.exit(code)
    except _TyperUsageError as exc:
        context = getattr(exc, "ctx", None)
        path = context.command_path if context is not None else "tedm"
        _fail(UsageError(exc.format_message().rstrip("."), hint=f"see `{path} --help`"))
    except TedmError as exc:
        _fail(exc)
    except KeyboardInterrupt:
        print("error: interrupted; finished files are kept, the unfinished one is removed", file=sys.stderr)
        sys.exit(_INTERRUPTED)
    except BrokenPipeError:
        # Whoever reads our output has left: what is still buffered must not raise a second time on leaving.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(1)
    except Exception as exc:
        if _verbosity >= 2:
            traceback.print_exc()
        print(f"error: internal fault: {type(exc).__name__}: {exc}", file=sys.stderr)
        print("hint: this is a defect of tedm; run again with -vv and report the traceback", file=sys.stderr)
        sys.exit(1)


def _fail(exc: TedmError) -> NoReturn:
    """Print `error: where: fact` (a line for each problem of a configuration) and `hint: fix`, and leave."""
    if _verbosity >= 2:
        traceback.print_exc()
    for line in str(exc).splitlines():
        prefix = f"{exc.where}: " if exc.where and not line.startswith(exc.where) else ""
        print(f"error: {prefix}{line}", file=sys.stderr)
    if exc.hint:
        print(f"hint: {exc.hint}", file=sys.stderr)
    sys.exit(exc.exit_code)


def _project(config: Path, build_dir: Path, verbose: int) -> Any:
    from tedm_cli.config.project import load_project

    global _verbosity
    _verbosity = verbose
    project = load_project(config, build_dir)
    if verbose:
        print(f"{project.title}: {config}, results in {build_dir}", file=sys.stderr)
    return project


def _say(quiet: bool, *lines: str) -> None:
    if not quiet:
        print("\n".join(lines))


def _version(value: bool) -> None:
    if value:
        print(f"tedm {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version and leave.")
    ] = False,
) -> None:
    """Options before the subcommand."""


@app.command("write-deck")
def write_deck(
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Output = None,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Write the unit-load deck for any Nastran.

    One subcase of +1 K per thermal area, and one that warms all areas together.
    """
    from tedm_cli.stages.deck import write_deck as stage

    done = stage(_project(config, build_dir, verbose), output)
    _say(quiet, f"{done.path}: {done.areas} unit loads and the uniform load on {done.grids:,} grids")


@app.command()
def solve(
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Output = None,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Solve the unit-load deck, write an OP2.

    The embedded solver takes CHEXA, CBAR, RBE2, RBE3, CONM2 and SPC; anything else is refused by name: run Nastran
    on the deck then.
    """
    from tedm_cli.progress import progress
    from tedm_cli.say import solve_lines
    from tedm_cli.stages.solve import solve as stage

    project = _project(config, build_dir, verbose)
    with progress(quiet) as step:
        path, done = stage(project, output, step)
    _say(quiet, *solve_lines(path, done))


@app.command()
def ingest(
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Output = None,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Deck and OP2 results to unit_loads.h5.

    Geometry, masses, thermal areas and displacements, in SI and the basic frame.
    """
    from tedm_cli.progress import progress
    from tedm_cli.say import partial_lines
    from tedm_cli.stages.ingest import ingest as stage

    project = _project(config, build_dir, verbose)
    with progress(quiet) as step:
        done = stage(project, output, step)
    x, y, z = done.centre_of_gravity_m
    _say(
        quiet,
        f"{done.path}: {done.grids:,} grids, {done.elements:,} elements, {done.areas} thermal areas",
        f"mass {done.total_kg:.9g} kg (elements: {done.reference_kg:.9g} kg), centre of gravity"
        f" ({x:.6g}, {y:.6g}, {z:.6g}) m in the basic frame",
        *([] if done.has_uniform else ["no uniform load: superposition will not be checked"]),
        *partial_lines(done.partial),
    )


@app.command("build-distortion")
def build_distortion(
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Output = None,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Unit loads to the distortion matrix [D].

    Per kelvin of every thermal area, for all grids and for the optical elements, with superposition checked.
    """
    from tedm_cli.progress import progress
    from tedm_cli.stages.distortion import build_distortion as stage

    project = _project(config, build_dir, verbose)
    with progress(quiet) as step:
        done = stage(project, output, step)
    check = "not checked (no uniform load)" if done.superposition is None else f"{done.superposition:.1e}"
    _say(
        quiet,
        f"{done.path}: D for {done.areas} areas, {done.grids:,} grids, {done.optical} optical elements",
        f"superposition residual {check}; largest translation {done.largest_m_per_K:.3g} m/K ({done.largest_area}),"
        f" largest rigid-body part {done.largest_rigid_m_per_K:.3g} m/K",
    )


@app.command("build-sensitivity")
def build_sensitivity(
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Output = None,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Self-gravity field, stiffness and [S_SG].

    On each test mass: acceleration at rest, four stiffness matrices, and the sensitivity to each thermal area.
    """
    from tedm_cli.progress import progress
    from tedm_cli.say import sensitivity_lines
    from tedm_cli.stages.sensitivity import build_sensitivity as stage

    project = _project(config, build_dir, verbose)
    with progress(quiet) as step:
        done = stage(project, output, step)
    _say(quiet, *sensitivity_lines(done))


@app.command("audit-mesh")
def audit_mesh(
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Annotated[Path | None, typer.Option("-o", "--output", help="Write every element to this CSV file.")] = None,
    figure: Annotated[
        Path | None, typer.Option("--figure", help="Draw every element's size against its gap (SVG).")
    ] = None,
    top: Annotated[int, typer.Option("--top", min=0, help="How many elements to name.")] = 10,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Elements too large for their gap.

    The error every element leaves in the self-gravity and its sensitivities, lumped and by quadrature, against 1 % of
    the requirement. Sensitivities follow the element's own motion once build-distortion has run.
    """
    from tedm_cli.progress import progress
    from tedm_cli.say import audit_lines
    from tedm_cli.stages.audit import audit as stage

    project = _project(config, build_dir, verbose)
    with progress(quiet) as step:
        done = stage(project, output, figure, step)
    if as_json:
        print(json.dumps(done.as_dict(top), indent=1))
    else:
        _say(quiet, *audit_lines(done, top))


@app.command("build-optics")
def build_optics(
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Output = None,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Ray trace, optics law and read-out matrices.

    S_BW by the analytic derivative of the ray trace, P, O_ideal, and the read-out per kelvin of every area.
    """
    from tedm_cli.say import optics_lines
    from tedm_cli.stages.optics import build_optics as stage

    done = stage(_project(config, build_dir, verbose), output)
    _say(quiet, *optics_lines(done))


@app.command("run-case")
def run_case(
    case: Annotated[list[str], typer.Argument(help="Case ids of the configuration (3, 4b), or `all`.")],
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Output = None,
    fail_on_violation: Annotated[
        bool, typer.Option("--fail-on-violation", help="Exit with 5 when a requirement is violated.")
    ] = False,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Noise spectra and verdicts of cases.

    Propagates the temperature noise of correlation cases to all outputs, exactly, and judges the requirements.
    """
    from tedm_cli.errors import PhysicsError
    from tedm_cli.progress import progress
    from tedm_cli.say import case_dict, case_lines
    from tedm_cli.stages.case import run_cases, select_cases

    project = _project(config, build_dir, verbose)
    ids = select_cases(project, case)
    if output is not None and len(ids) != 1:
        raise UsageError(f"--output names one file, but {len(ids)} cases are run")
    with progress(quiet) as step:
        done = run_cases(project, ids, output, step)
    if as_json:
        print(json.dumps([case_dict(path, result) for path, result in done], indent=1))
    else:
        for path, result in done:
            _say(quiet, *case_lines(path, result))
    failed = [r.case.id for _, r in done if not all(v.passed for v in r.verdicts)]
    if fail_on_violation and failed:
        raise PhysicsError(f"requirements are violated in case {', '.join(failed)}")


@app.command()
def plot(
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Annotated[Path | None, typer.Option("-o", "--output", help="Folder of the figures.")] = None,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Draw the figures of all cases run."""
    from tedm_cli.progress import progress
    from tedm_cli.stages.plot import plot as stage

    project = _project(config, build_dir, verbose)
    with progress(quiet) as step:
        paths = stage(project, output, step)
    _say(quiet, f"{paths[0].parent}: {len(paths)} figures")


@app.command()
def report(
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Output = None,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Write the self-contained report.html."""
    from tedm_cli.stages.report import report as stage

    path = stage(_project(config, build_dir, verbose), output)
    _say(quiet, f"{path}: {path.stat().st_size / 1e6:.1f} MB")


@app.command("self-gravity")
def self_gravity(
    points: Annotated[Path, typer.Option("--points", help="CSV with the header x_m,y_m,z_m,mass_kg (basic frame).")],
    config: Config = DEFAULT_CONFIG,
    output: Annotated[Path | None, typer.Option("-o", "--output", help="Write a .json or .csv file.")] = None,
    per_source: Annotated[bool, typer.Option("--per-source", help="Also what each source contributes.")] = False,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Field of point sources on the test masses.

    Force, torque, accelerations and four stiffness matrices of a list of masses, with the exact kernel of a cuboid.
    """
    from tedm_cli.say import point_field_lines
    from tedm_cli.stages.self_gravity import point_dict, point_self_gravity

    project = _project(config, DEFAULT_BUILD, verbose)
    done = point_self_gravity(project, points, per_source=per_source, output=output)
    if as_json:
        print(json.dumps(point_dict(done), indent=1))
    else:
        _say(quiet, *point_field_lines(done))


@app.command()
def accuracy(
    figure: Annotated[str, typer.Argument(help="Study by its published figure: 6.4, 7.2, 7.3, 7.8, 7.9 or 8.1.")],
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Annotated[Path | None, typer.Option("-o", "--output", help="Folder of the data and the figure.")] = None,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Numerical error of a method, against the exact kernel.

    7.2 and 7.8: published quadratures over the test mass. 7.3 and 7.9: size of elements. 8.1: linearisation.
    6.4: mesh of the compensation masses. Writes data (CSV) and the figure (SVG).
    """
    from tedm_cli.say import accuracy_lines
    from tedm_cli.stages.accuracy import accuracy as stage

    _say(quiet, *accuracy_lines(stage(_project(config, build_dir, verbose), figure, output)))


@app.command()
def show(
    file: Annotated[Path, typer.Argument(help="An HDF5 file of tedm.")],
    as_json: Json = False,
) -> None:
    """Show what a file holds.

    Datasets with their units, what it was made from, and its main numbers.
    """
    from tedm_cli.stages.show import show_dict, show_lines

    if as_json:
        print(json.dumps(show_dict(file), indent=1))
    else:
        print("\n".join(show_lines(file)))


@app.command()
def check(
    build_dir: BuildDir = DEFAULT_BUILD,
    as_json: Json = False,
) -> None:
    """Check that all files are up to date.

    Every HDF5 file of the build folder: its contract, its version, and whether its inputs are still the same.
    """
    from tedm_cli.errors import InputError
    from tedm_cli.stages.check import check_folder

    results = check_folder(build_dir)
    if as_json:
        print(json.dumps([r.as_dict() for r in results], indent=1))
    else:
        for r in results:
            print("\n".join(r.lines()))
    bad = [r.path.name for r in results if r.problems]
    if bad:
        raise InputError(
            f"{len(bad)} of {len(results)} files are not up to date: {', '.join(bad)}",
            where=str(build_dir),
            hint="run make all",
        )


@app.command("make-rules", hidden=True)
def make_rules(config: Config = DEFAULT_CONFIG, build_dir: BuildDir = DEFAULT_BUILD, output: Output = None) -> None:
    """Write the Make variables of a project: its inputs and its cases."""
    from tedm_cli.stages.make_rules import make_rules as stage

    stage(_project(config, build_dir, 0), output)


if __name__ == "__main__":
    main()
