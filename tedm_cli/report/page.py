"""The report: numbers of open result files, arranged for its template. Reads arrays, computes next to nothing."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any

import jinja2
import numpy as np
from markupsafe import Markup

from tedm_cli import __version__
from tedm_cli.errors import InputError
from tedm_cli.figures.data import (
    SUPERSCRIPT,
    Areas,
    CaseNoise,
    JudgedOutput,
    first_largest,
    mhz_text,
    ratio_text,
    unit_text,
)
from tedm_cli.figures.inline import inline_svg
from tedm_cli.provenance import relative_name
from tedm_cli.report.field import field_at_rest
from tedm_cli.report.optics import optics_of
from tedm_cli.store import Reader

_TOP = 5  # areas listed for each judged output


@dataclass(frozen=True)
class ReportFigure:
    """A figure to be placed in a section of the report: its caption and the text of its SVG file."""

    section: str
    caption: str
    svg: str


@dataclass(frozen=True)
class ReportFile:
    """A result file: open, with the SHA-256 of what it holds."""

    reader: Reader
    sha256: str


@dataclass(frozen=True)
class ReportInputs:
    """All that a report is made from; `files` are all result files in the order of the chain."""

    title: str
    unit_loads: Reader
    distortion: Reader
    sensitivity: Reader
    optics: Reader
    cases: list[CaseNoise]
    files: list[ReportFile]
    figures: list[ReportFigure]


def render(inputs: ReportInputs) -> str:
    """One HTML page that needs nothing but itself.

    Raises
    ------
    InputError : files stem from different versions of one configuration.
    """
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("tedm_cli.report"),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    environment.filters.update(sci=sci, ratio=ratio_text, mhz=mhz_text, span=span_text, unit=unit_text)
    areas = Areas(*(inputs.sensitivity.strings(f"/area/{c}") for c in ("name", "group", "shield")))
    return environment.get_template("report.html.j2").render(
        title=inputs.title,
        version=__version__,
        cases=inputs.cases,
        setting=_setting(inputs.cases),
        verdicts=_verdicts(inputs.cases),
        limits=[q for q in inputs.cases[0].limits if any(j.requirement == q.name for j in inputs.cases[0].judged)],
        contributors=_contributors(inputs.cases, areas),
        field=field_at_rest(inputs.sensitivity),
        optics=optics_of(inputs.optics),
        distortion=_distortion(inputs.distortion),
        model=_model(inputs.unit_loads),
        figures=_figures(inputs.figures),
        provenance=_provenance(inputs.files, inputs.figures),
    )


def span_text(low: float, high: float) -> str:
    """A range of ratios; one number where its ends read the same."""
    ends = ratio_text(low), ratio_text(high)
    return ends[0] if ends[0] == ends[1] else " to ".join(ends)


def sci(value: float, digits: int = 4) -> str:
    """A number with powers of ten raised, plain where it is of everyday size."""
    if value == 0.0 or not math.isfinite(value):
        return f"{value:g}".replace("-0", "0").replace("-", "−")
    if 1e-3 <= abs(value) < 1e5:
        return f"{value:.{digits}g}".replace("-", "−") if abs(value) < 10**digits else f"{value:.0f}".replace("-", "−")
    mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
    return f"{mantissa} × 10{str(int(exponent)).translate(SUPERSCRIPT)}".replace("-", "−")


def _setting(cases: Sequence[CaseNoise]) -> dict[str, Any]:
    first = cases[0]
    return {
        "temperature": first.temperature,
        "safety_factor": first.safety_factor,
        "orders": ", ".join(f"{v:g}" for v in first.filter_order),
        "corners": ", ".join(f"{v * 1e3:g}" for v in first.filter_corner_hz),
    }


def _verdicts(cases: Sequence[CaseNoise]) -> list[dict[str, Any]]:
    """What to say first of each requirement: where it is met, how badly it is missed, and how sure that is."""
    sentences = []
    for limit in cases[0].limits:
        by_case = [(c, [j for j in c.judged if j.requirement == limit.name]) for c in cases]
        by_case = [(c, js) for c, js in by_case if js]
        if not by_case:
            continue
        pairs = [(c, j) for c, js in by_case for j in js]
        case, worst = first_largest(pairs, [j.ratio for _, j in pairs])
        met = [c.id for c, js in by_case if all(j.passed for j in js)]
        sentences.append(
            {
                "limit": limit,
                "outputs": ", ".join(dict.fromkeys(j.output for _, j in pairs)),
                "met": met,
                "violated": [c.id for c, _ in by_case if c.id not in met],
                "cases": len(by_case),
                "case": case,
                "worst": worst,
                "filters": _over_filters([js for _, js in by_case]),
            }
        )
    return sentences


def _over_filters(by_case: Sequence[Sequence[JudgedOutput]]) -> dict[str, int] | None:
    """In how many cases a requirement is met with every temperature filter tried, with some, and with none."""
    count: Counter[str] = Counter()
    for judged in by_case:
        ratios = [j.filter_ratio for j in judged if j.filter_ratio is not None]
        if len(ratios) != len(judged):
            return None
        met = np.max(ratios, axis=0) <= 1.0
        count["all" if met.all() else "some" if met.any() else "none"] += 1
    return {key: count[key] for key in ("all", "some", "none")}


def _contributors(cases: Sequence[CaseNoise], areas: Areas) -> list[dict[str, Any]]:
    """For each judged output, in the case where it is worst: the areas and groups its noise comes from."""
    found = []
    for output in dict.fromkeys(j.output for c in cases for j in c.judged):
        pairs = [(c, j) for c in cases for j in c.judged if j.output == output]
        case, j = first_largest(pairs, [p.ratio for _, p in pairs])
        order = np.argsort(-np.abs(j.share), kind="stable")[:_TOP]
        groups = list(dict.fromkeys(areas.group))
        member = np.array([[g == name for g in areas.group] for name in groups], dtype=float)
        at, band = member @ j.share, member @ j.band_share
        found.append(
            {
                "case": case,
                "judged": j,
                "areas": [
                    (areas.name[i], areas.group[i], areas.shield[i], j.contribution[i], j.share[i], j.band_share[i])
                    for i in order
                ],
                "groups": [
                    (groups[g], areas.group.count(groups[g]), at[g], band[g])
                    for g in np.argsort(-np.abs(at), kind="stable")
                ],
            }
        )
    return found


def _distortion(file: Reader) -> dict[str, Any]:
    names = file.strings("/area/name")
    largest, rigid = (
        file.array("/check/max_translation"),
        np.linalg.norm(file.array("/check/rigid_translation"), axis=1),
    )
    residuals = [
        (what, file.number(f"/check/superposition_{key}"))
        for key, what in (("translation", "translations of all grids"), ("optics", "rotations of the optical elements"))
        if file.has(f"/check/superposition_{key}")
    ]
    return {
        "residuals": residuals,
        "largest": (float(largest.max()), names[int(largest.argmax())]),
        "rigid": (float(rigid.max()), names[int(rigid.argmax())]),
        "optical": len(file.strings("/optical/name")),
    }


def _model(file: Reader) -> dict[str, Any]:
    types, mass = file.strings("/element/type"), file.array("/element/mass")
    kinds = [(t, n, float(mass[np.array(types) == t].sum())) for t, n in sorted(Counter(types).items())]
    groups, shields = file.strings("/area/group"), file.strings("/area/shield")
    area_mass = file.array("/area/mass")
    by_group = []
    for group in dict.fromkeys(groups):
        members = [i for i, g in enumerate(groups) if g == group]
        sides = ", ".join(sorted({shields[i] for i in members}))
        by_group.append((group, len(members), sides, float(area_mass[members].sum())))
    return {
        "grids": file.dataset("/grid/id").shape[0],
        "elements": len(types),
        "kinds": kinds,
        "concentrated": (file.dataset("/mass/concentrated").shape[0], float(file.array("/mass/concentrated").sum())),
        "mass": file.number("/mass/total"),
        "centre_of_gravity": file.array("/mass/centre_of_gravity"),
        "areas": len(groups),
        "groups": by_group,
        "area_mass": float(area_mass.sum()),
    }


def _figures(figures: Sequence[ReportFigure]) -> dict[str, list[dict[str, Any]]]:
    names = (
        "verdict", "certainty", "all cases", "contributors", "mending", "series", "sensitivity", "field", "bench",
        "optics", "read-out", "load", "cases",
    )  # fmt: skip
    sections: dict[str, list[dict[str, Any]]] = {name: [] for name in names}
    for number, figure in enumerate(figures):
        svg = Markup(inline_svg(figure.svg, f"f{number}-", figure.caption))
        sections[figure.section].append({"caption": figure.caption, "svg": svg})
    return sections


def _provenance(files: Sequence[ReportFile], figures: Sequence[ReportFigure]) -> dict[str, Any]:
    """Configurations, inputs, commands and versions of all files, each once; names are as seen from their folder."""
    configs: dict[str, tuple[str, str]] = {}
    inputs: dict[str, str] = {}
    rows = []
    versions: dict[str, str] = {}
    for file in files:
        reader = file.reader
        folder = reader.path.parent
        provenance = reader.provenance()
        for config in provenance.configs:
            name = relative_name(config.path, folder)
            if configs.setdefault(name, (config.sha256, config.text))[0] != config.sha256:
                raise InputError(
                    f"and files before it were made from different versions of {config.path}",
                    where=str(reader.path),
                    hint="rebuild them; see tedm check",
                )
        inputs.update((relative_name(i.path, folder), i.sha256) for i in provenance.inputs)
        inputs[reader.path.name] = file.sha256
        rows.append((reader.path.name, provenance.command))
        for key, value in reader.attributes.items():
            if key.endswith("_version") and key != "schema_version":
                name = key.removesuffix("_version")
                found = versions.setdefault(name, str(value))
                versions[name] = found if str(value) in found.split(" and ") else f"{found} and {value}"
    versions["jinja2"] = version("jinja2")
    drawn = {m[1] for f in figures for m in re.finditer(r"<dc:title>tedm \S+, matplotlib (\S+?)</dc:title>", f.svg)}
    versions["matplotlib"] = " and ".join(sorted(drawn))
    return {
        "configs": [(name, sha, text) for name, (sha, text) in sorted(configs.items())],
        "inputs": sorted(inputs.items()),
        "commands": rows,
        "versions": sorted(versions.items(), key=lambda v: v[0].lower()),
    }
