"""make-rules: what Make has to know of a project, so that it rebuilds what depends on a change and nothing else."""

from __future__ import annotations

from pathlib import Path

from tedm_cli.areas.configured import area_csv
from tedm_cli.config.cases import load_cases
from tedm_cli.config.compensation import compensation_file
from tedm_cli.config.model import load_model
from tedm_cli.config.optics import load_optics
from tedm_cli.config.project import Project
from tedm_cli.config.temperature_tables import table_paths
from tedm_cli.files.build_folder import case_file_name
from tedm_cli.files.store import replacing


def make_rules(project: Project, output: Path | None) -> Path:
    """Write the variables of one project; `SOLVED_BY_TEDM` is empty where the user's own results are named."""
    _, model = load_model(project.model)
    _, cases = load_cases(project.cases)
    deck = project.resolve(model.model.deck)
    results = [project.resolve(p) for p in model.model.op2]
    own = all("{build_dir}" in p for p in (model.model.deck, *model.model.op2))
    listed = area_csv(project, model)
    sources = [*([] if model.model.bdf is None else [project.resolve(model.model.bdf)]), *([listed] if listed else [])]
    blocks = compensation_file(project, model)
    lines = [
        f"MODEL_TOML := {project.model}",
        f"OPTICS_TOML := {project.optics}",
        f"CASES_TOML := {project.cases}",
        f"MODEL_SOURCES := {' '.join(str(s) for s in sources) if own else ''}",
        f"AREAS_CSV := {listed or ''}",
        f"UNIT_DECK := {deck}",
        f"OP2 := {' '.join(str(r) for r in results)}",
        f"SOLVED_BY_TEDM := {'yes' if own else ''}",
        f"GRAVITY_SOURCES := {'' if blocks is None else blocks}",
        f"OPTICS_SOURCES := {' '.join(str(f) for f in load_optics(project.optics).matrices)}",
        f"CASE_SOURCES := {' '.join(str(p) for p in (*cases.tables, *cases.matrices))}",
        f"SPECTRA := {' '.join(str(p) for p in table_paths(project, cases))}",
        f"CASE_IDS := {' '.join(cases.ids)}",
        f"CASE_FILES := {' '.join(str(project.build_dir / case_file_name(c)) for c in cases.ids)}",
    ]
    lines += [f"CASE_ID_{case_file_name(c)} := {c}" for c in cases.ids]
    out = output if output is not None else project.build_dir / "rules.mk"
    with replacing(out) as temporary:
        temporary.write_text("\n".join(lines) + "\n", encoding="utf-8", newline="\n")
    return out
