"""Write the optical layout of the LISA-like sample: two benches at 60 degrees, synthetic, not a flight layout.

Each assembly has a frame of its own: x towards its far spacecraft, z out of the bench, the origin at the centre of its
test mass. Both have the same elements in it; the file has those of the two assemblies turned by +30 and -30 degrees.

Usage: python sample_models/lisa_like_layout.py -o configs/lisa_like/optics.toml
"""

from __future__ import annotations

import argparse
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

APART_DEG = 60.0  # angle between the two arms
VERTEX_MM = 300.0  # from the point where the axes of both assemblies meet to each test mass
THICKNESS, INDEX = 5.0, 1.4496  # beam-splitters, mm
WINDOW, WINDOW_INDEX = 12.0, 1.607
FACE = 23.0  # mm, half the edge of the test mass
DIAGONAL = math.sqrt(0.5)

# A plate at 45 degrees shifts a beam sideways by SHIFT, and makes its optical path longer by EXCESS.
_INSIDE = math.asin(DIAGONAL / INDEX)
SHIFT = THICKNESS * math.sin(math.pi / 4 - _INSIDE) / math.cos(_INSIDE)
EXCESS = THICKNESS * (INDEX - math.cos(math.pi / 4 - _INSIDE)) / math.cos(_INSIDE)

HEAD = """\
# SYNTHETIC layout of a LISA-like instrument: two optical benches at 60 degrees to each other, each with one test mass
# and the local interferometer that reads it. It is NOT a flight layout. sample_models/lisa_like_layout.py wrote it:
# change it there, or copy this file for your own layout.
#
# Layout frame: x along the bisector of the two arms, z out of the benches. Metres and radians. The test masses have
# axes of their own: x towards the far spacecraft, z out of the bench. `tedm init --from ltp` writes a layout that
# explains all keys.
#
# On each bench the measurement beam (FIT) passes a pick-off (BST) and the polarising beam-splitter (PBS), meets the
# test mass at normal incidence through the window (W), and is reflected by the PBS to the recombiner (BSR). The local
# oscillator (FIL) comes by a mirror (M) and a pick-off (BSL). Pick-offs feed interferometers that are not modelled.

title = "LISA-like layout, two benches at 60 degrees (synthetic, not a flight layout)"
wavelength_m = 1.064e-6
read_out = ["x", "eta", "phi"]  # of each test mass, along and about its own axes

[frame]
origin_m = [0.0, 0.0, 0.0]
axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]

[tolerances]
clearance_m = 0.0015
beam_overlap_m = 1e-6
beam_angle_rad = 1e-6
path_mismatch_m = 1e-6

[sets]  # redundant read-outs
A = ["PD1A", "PD2A"]
B = ["PD1B", "PD2B"]
"""


@dataclass(frozen=True)
class Part:
    """One element in the frame of its assembly: what it is, where (mm, in the plane of the beams), its normal there."""

    name: str
    kind: str
    what: str
    at: tuple[float, float]
    normal: tuple[float, float]
    aperture_mm: float
    keys: str = ""


def parts(number: int) -> list[Part]:
    """The elements of one bench, its test mass first."""
    plate = f"thickness_m = {THICKNESS / 1e3}\nindex = {INDEX}\n"
    offset = f"front_offset_m = {FACE / 1e3}\n"
    into, back = (DIAGONAL, DIAGONAL), (-DIAGONAL, DIAGONAL)
    splitter_x, oscillator_y = 200.0, 95.0
    recombined = (splitter_x + SHIFT, oscillator_y - SHIFT)
    diode_y, diode_x = 145.0, 110.0
    source, oscillator = (340.0, 0.0), (310.0, 150.0)
    # Both paths end on the same photodiode; what the local oscillator lacks, it has travelled before its injector.
    measured = source[0] + splitter_x - 2 * FACE + recombined[1] + 2 * EXCESS + 2 * WINDOW * (WINDOW_INDEX - 1.0)
    local = oscillator[1] - oscillator_y + oscillator[0] - recombined[0]
    n = number
    window = f"front_offset_m = {WINDOW / 2e3}\nthickness_m = {WINDOW / 1e3}\nindex = {WINDOW_INDEX}\n"
    earlier = f"opl_offset_m = {(measured - local) / 1e3:.12f}\n"
    return [
        Part(f"TM{n}", "test_mass", "face towards the far spacecraft", (0.0, 0.0), (1.0, 0.0), FACE, offset),
        Part(f"FIT{n}", "injector", "fibre injector, measurement beam", source, (-1.0, 0.0), 4.0),
        Part(f"FIL{n}", "injector", "fibre injector, local oscillator", oscillator, (0.0, -1.0), 4.0, earlier),
        Part(f"W{n}", "window", "vacuum window", (63.0, 0.0), (1.0, 0.0), 22.0, window),
        Part(f"BST{n}", "beamsplitter", "pick-off, only transmits here", (285.0, 0.0), into, 7.0, plate),
        Part(f"PBS{n}", "beamsplitter", "to the test mass and back", (splitter_x, 0.0), back, 7.0, plate),
        Part(f"BSL{n}", "beamsplitter", "pick-off, only transmits here", (260.0, oscillator_y), into, 7.0, plate),
        Part(f"BSR{n}", "beamsplitter", "recombiner", recombined, into, 7.0, plate),
        Part(f"M{n}", "mirror", "folds the local oscillator", (oscillator[0], oscillator_y), back, 7.0),
        Part(f"PD{n}A", "photodiode", "set A", (recombined[0], diode_y), (0.0, -1.0), 2.5),
        Part(f"PD{n}B", "photodiode", "set B", (diode_x, recombined[1] - SHIFT), (1.0, 0.0), 2.5),
    ]


def rotation(number: int) -> np.ndarray:
    """Frame of an assembly to the basic frame, [3, 3]."""
    angle = math.radians(APART_DEG / 2) * (1 if number == 1 else -1)
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def placed(number: int, points_mm: np.ndarray) -> np.ndarray:
    """Points [..., 3] mm of the frame of an assembly in the basic frame."""
    return np.asarray((points_mm + np.array([VERTEX_MM, 0.0, 0.0])) @ rotation(number).T)


def numbers(values: np.ndarray, digits: int) -> str:
    """A vector as TOML; without minus zeros."""
    return "[" + ", ".join(f"{round(float(v), digits) + 0.0:.{digits}g}" for v in values) + "]"


def element(number: int, place: int, part: Part) -> str:
    at = placed(number, np.array([*part.at, 0.0])) / 1e3
    lines = [f"[[element]]  # {part.what}", f'name = "{part.name}"', f'kind = "{part.kind}"']
    if part.kind == "test_mass":
        rows = ", ".join(numbers(row, 15) for row in rotation(number).T)
        lines.append(f"axes = [{rows}]")
    else:
        lines.append(f"grid = {900000 + 100 * number + place}")
    if part.kind == "injector":  # beams join the rest of its bench to it
        lines.append(f'bench = "OB{number}"')
    lines.append(f"ref_m = {numbers(at, 12)}")
    lines.append(f"normal = {numbers(rotation(number) @ np.array([*part.normal, 0.0]), 15)}")
    lines += part.keys.splitlines()
    if part.kind in ("test_mass", "photodiode"):
        lines.append("local_y = [0.0, 0.0, 1.0]")
    size = part.aperture_mm / 1e3
    lines.append(f"aperture_m = [{size}, {size}]" if part.kind == "test_mass" else f"aperture_m = {size}")
    return "\n".join(lines) + "\n"


def paths(number: int) -> str:
    n = number
    measured = [f"FIT{n}", f"BST{n}:T", f"PBS{n}:T", f"W{n}:T", f"TM{n}:R", f"W{n}:T", f"PBS{n}:R"]
    local = [f"FIL{n}", f"M{n}:R", f"BSL{n}:T"]
    out = []
    for letter, ops in (("A", ("T", "R")), ("B", ("R", "T"))):
        for beam, steps, op in (("meas", measured, ops[0]), ("ref", local, ops[1])):
            listed = ", ".join(f'"{s}"' for s in (*steps, f"BSR{n}:{op}", f"PD{n}{letter}"))
            out.append(f'[[path]]\nphotodiode = "PD{n}{letter}"\nbeam = "{beam}"\nsteps = [{listed}]\n')
    return "\n".join(out)


def layout_text() -> str:
    """The whole file."""
    blocks = [HEAD]
    for number in (1, 2):
        blocks += [element(number, place, part) for place, part in enumerate(parts(number))]
    return "\n".join([*blocks, *(paths(number) for number in (1, 2))])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", type=Path, required=True)
    args = parser.parse_args()
    args.output.parent.mkdir(parents=True, exist_ok=True)
    args.output.write_text(layout_text(), encoding="ascii", newline="\n")


if __name__ == "__main__":
    main()
