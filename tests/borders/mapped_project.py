"""Two bricks with thermal nodes on them, for the tests of their map."""

from __future__ import annotations

import json
from pathlib import Path

from border_tools import Project, untouched

K = "[map.conductivity_W_m_K]\n1 = 150.0\n"
ELEMENTS = '[map]\nelements = "nodes.csv"\n'
BY_ELEMENT = "tmm_node,element_id\nLOW,1\nHIGH,2\n"


def with_map(project: Project, text: str, **files: str) -> Project:
    """The project with a thermal model, and files beside it."""
    (project.folder / "thermal.toml").write_text(text)
    for name, content in files.items():
        (project.folder / f"{name}.csv").write_text(content)
    file = project.folder / "tedm.toml"
    if "thermal =" not in file.read_text():
        file.write_text('thermal = "thermal.toml"\n' + file.read_text())
    return project


def mapped(project: Project, *args: object) -> dict:
    return json.loads(project.run("map-temperatures", project.folder / "tau.csv", "--json", *args).ok().out)


def fields(path: Path) -> dict[str, dict[int, float]]:
    """Temperatures by set and grid."""
    head, *rows = [line.split(",") for line in path.read_text().splitlines()]
    assert head[0] == "grid"
    return {name: {int(r[0]): float(r[i]) for r in rows} for i, name in enumerate(head[1:], 1)}


def refused(project: Project, code: int, *pieces: str, hint: str = "") -> None:
    with untouched(project.folder):
        project.run("map-temperatures", project.folder / "tau.csv", "-o", project.folder / "new.csv").refused(
            code, *pieces, hint=hint
        )


WAYS = {
    "elements": ELEMENTS,
    "element": '[[map.node]]\nname = "LOW"\nelement = 1\n[[map.node]]\nname = "HIGH"\nelement = "2:9"\n',
    "box": '[[map.node]]\nname = "LOW"\nbox = { x_m = [0.0, 0.1] }\n'
    '[[map.node]]\nname = "HIGH"\nbox = { x_m = [0.1, 0.2] }\n',
    "set": '[[map.node]]\nname = "LOW"\nset = 4\n[[map.node]]\nname = "HIGH"\nset = 5\n',
    "nearest": '[map]\nnearest = "places.csv"\n',
    "both": '[map]\nnearest = "places.csv"\n[[map.node]]\nname = "HIGH"\nelement = 2\n',
}
