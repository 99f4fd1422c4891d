"""A project with a small thermal network of every kind of node, as files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import h5py
import numpy as np
from border_tools import Project

FILES = {
    "tedm.toml": 'title = "network"\nthermal = "thermal.toml"\n',
    "thermal.toml": """\
[network]
nodes = "nodes.csv"
conductors = "conductors.csv"
powers = "powers.csv"

[frequency]
list_hz = [1e-5, 1e-4, 3e-4, 1e-3, 3e-3, 1e-2]

[[disturbance]]
name = "panel"
nodes = ["SC"]
kind = "temperature"
preset = "white"
level_K = 1e-3

[[disturbance]]
name = "bus"
nodes = ["BOX", "OB"]
weights = [0.8, 0.2]
kind = "power"
table = "bus.csv"

[[correlation]]
disturbances = ["panel", "bus"]
rho = 0.5
""",
    "nodes.csv": """\
node,capacity_J_K,kind,temperature_K
SC,0,boundary,293.15
SPACE,0,boundary,3
SHIELD,2000,diffusive,
OB,5000,diffusive,
BOX,800,diffusive,
JOINT,0,arithmetic,
""",
    "conductors.csv": """\
node_a,node_b,GL_W_K,GR_m2
SC,SHIELD,0.02,0.05
SHIELD,JOINT,0.1,0
JOINT,OB,0.1,0
SHIELD,OB,0,0.2
BOX,OB,0.5,0
BOX,SPACE,0,0.005
SC,SPACE,0,1
""",
    "powers.csv": "node,power_W\nBOX,2\nBOX,1\n",
    "bus.csv": "frequency_hz,amplitude\n1e-5,1e-2\n1,1e-4\n",
}


class ThermalProject(Project):
    """The files in a folder, and the command on them."""

    def __init__(self, folder: Path) -> None:
        super().__init__(folder)
        folder.mkdir(parents=True, exist_ok=True)
        for name, text in FILES.items():
            (folder / name).write_text(text, encoding="utf-8")

    def change(self, name: str, old: str, new: str) -> None:
        path = self.folder / name
        text = path.read_text(encoding="utf-8")
        assert old in text, f"{old!r} is not in {name}"
        path.write_text(text.replace(old, new, 1), encoding="utf-8")

    def file(self) -> h5py.File:
        return h5py.File(self.build / "thermal.h5", "r")


#: The same network as `FILES` in the layout of ESATAN-TMS, its nodes by number; 99 is inactive.
NUMBERS = {"SC": 1, "SPACE": 2, "SHIELD": 10, "OB": 20, "BOX": 30, "JOINT": 40, "OUT": 99}
REAL = ("T", "C", "QA", "QE", "QI", "QR", "QS", "A", "ALP", "EPS", "FX", "FY", "FZ")


def write_tmd(path: Path, temperature_K: dict[str, float], **changed: Any) -> None:
    """A `.TMD` file of two times, the second that of the network; `changed` has datasets or attributes by name."""
    rows = [line.split(",") for line in FILES["nodes.csv"].splitlines()[1:]]
    names = [row[0] for row in rows] + ["OUT"]
    kind = {"boundary": "B", "diffusive": "D", "arithmetic": "D"}
    real = np.zeros((2, len(names), len(REAL)))
    real[:, :-1, 1] = [float(row[1]) for row in rows]
    real[1, :-1, 0] = [temperature_K[name] - 273.15 for name in names[:-1]]
    real[1, names.index("BOX"), REAL.index("QI")] = 2.0
    real[1, names.index("BOX"), REAL.index("QR")] = 1.0
    words = np.array([[[kind[row[2]], row[0]] for row in rows] + [["X", "OUT"]]] * 2).astype("S8")
    lines = [line.split(",") for line in FILES["conductors.csv"].splitlines()[1:]]
    data: dict[str, Any] = {
        "thermalNodes": np.array([[NUMBERS[name], 0] for name in names], dtype=np.int32),
        "thermalNodesRealAttributes": np.array(REAL, dtype="S8"),
        "thermalNodesStringAttributes": np.array(["TYPE", "LABEL"], dtype="S8"),
        "DataGroup1/times": np.array([0.0, 3600.0]),
        "DataGroup1/thermalNodesRealData": real,
        "DataGroup1/thermalNodesStringData": words,
    }
    for column, letters in ((2, "GL"), (3, "GR")):
        used = [line for line in lines if float(line[column])] + [["OB", "OUT", "9", "9"]]
        data[f"conductors{letters}"] = np.array(
            [[names.index(x) + 1 for x in line[:2]] for line in used], dtype=np.int32
        )
        data[f"DataGroup1/conductorData{letters}"] = np.array([[[float(line[column])] for line in used]] * 2)
    attributes: dict[str, Any] = {"TAbs": 273.15}
    for name, value in changed.items():
        where = attributes if name in attributes else data
        key = next((k for k in data if k.endswith(name)), name)
        where[name if where is attributes else key] = value
    with h5py.File(path, "w") as file:
        group = file.create_group("AnalysisSet1")
        for name, value in data.items():
            if value is not None:
                group[name] = value
        for name, value in attributes.items():
            if value is not None:
                group.attrs[name] = value
