"""Plain titles of outputs and requirements, for readers who do not know the labels that commands and files use."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from tedm_cli.dynamics.signals import OUTPUTS
from tedm_cli.gravity.requirement_presets import PRESETS as AT_REST_PRESETS
from tedm_cli.gravity.requirements import ALL
from tedm_cli.noise.requirement_presets import PRESETS
from tedm_cli.results.wording import and_text

ANGLES = {"theta": "θ", "eta": "η", "phi": "φ"}
#: What the subsystems of LISA Pathfinder are.
SUBSYSTEM_TITLES = {"IS": "inertial sensor", "LTP": "rest of the LTP", "S/C": "rest of the satellite"}
_TURNS_ABOUT = {"theta": "x", "eta": "y", "phi": "z"}
_DELTA_G = {
    "delta_g": "differential acceleration Δg (as LISA Pathfinder computes it)",
    "delta_g_full": "differential acceleration Δg (all cross stiffness subtracted)",
    "delta_g_true": "differential acceleration Δg (the true one, which no instrument measures)",
}
_LOOP = set(OUTPUTS)


@dataclass(frozen=True)
class _Named:
    """`words` with {mass} in place of the test mass; what is read out has a set."""

    words: str
    mass: str = ""
    set: str = ""

    def text(self) -> str:
        return _told(self.words, [self.mass], [self.set])


def _told(words: str, masses: Sequence[str], sets: Sequence[str]) -> str:
    out = words.replace("{mass}", _masses(masses))
    return f"{out}, set{'s' * (len(sets) > 1)} {and_text(sets)}" if any(sets) else out


def output_title(labels: str) -> str:
    """Plain title of an output by its label; of several that are told once, `A_TM1_x, B_TM1_x`, one title for all.

    A label that follows no scheme of labels is its own title.
    """
    return outputs_title(labels.split(", "))


def outputs_title(labels: Sequence[str]) -> str:
    """One plain title of several outputs: alike ones share their words, with every test mass and set of theirs."""
    by_words: dict[str, list[_Named]] = {}
    for named in map(_named, dict.fromkeys(labels)):
        by_words.setdefault(named.words, []).append(named)
    said = []
    for words, alike in by_words.items():
        masses, sets = (sorted(set(names)) for names in ([n.mass for n in alike], [n.set for n in alike]))
        if len(alike) == len(masses) * len(sets):
            said.append(_told(words, masses, sets))
        else:
            said += [_told(words, [m], [n.set for n in alike if n.mass == m]) for m in masses]
    return and_text(said)


def _named(label: str) -> _Named:
    if label in _DELTA_G:
        return _Named(_DELTA_G[label])
    if "-" in label and label not in _LOOP:
        first, _, second = label.partition("-")
        a, b = _named(first), _named(second)
        same = a.mass and b.mass and (a.words, a.set) == (b.words, b.set)
        return _Named(f"{a.text()} minus {'that of ' + _masses([b.mass]) if same else b.text()}")
    if found := re.fullmatch(r"SC_(theta|eta|phi|a_[xyz]|omegadot_[xyz])", label):
        return _Named(_motion(found[1], "attitude {} of the spacecraft").replace("{mass}", "the spacecraft"))
    if found := re.fullmatch(r"H([12])_a_([xyz])", label):
        return _Named(f"acceleration of the housing of {{mass}} along {found[2]}", f"TM{found[1]}")
    if label in _LOOP and (found := re.fullmatch(r"meas_(.+)_(x|y|z|theta|eta|phi)", label)):
        of = "the spacecraft" if found[1] == "SC" else "{mass}"
        return _Named(f"measured {ANGLES.get(found[2], found[2])} of {of}", "" if found[1] == "SC" else found[1])
    if label in _LOOP and (found := re.fullmatch(r"u_(.+)_([FL])([xyz])", label)):
        of = "the spacecraft" if found[1] == "SC" else "{mass}"
        what = "force along" if found[2] == "F" else "torque about"
        return _Named(f"commanded {what} {found[3]} on {of}", "" if found[1] == "SC" else found[1])
    if found := re.fullmatch(r"(.+)_(a_[xyz]|omegadot_(?:[xyz]|theta|eta|phi))", label):
        return _Named(_motion(found[2], ""), found[1])
    if label in _LOOP and (found := re.fullmatch(r"(.+)_(x|y|z|theta|eta|phi)", label)):
        return _Named(_motion(found[2], "rotation {} of {{mass}} in its housing"), found[1])
    if found := re.fullmatch(r"([^_]+)_([^_]+)_(x|y|z|theta|eta|phi)", label):
        return _Named(f"read-out of {ANGLES.get(found[3], found[3])}, {{mass}}", found[2], found[1])
    if found := re.fullmatch(r"(.+_.+)_(x|y|z|theta|eta|phi)", label):  # which part names the set is not plain
        return _Named(f"read-out of {ANGLES.get(found[2], found[2])}, {found[1]}")
    return _Named(label)


def _motion(name: str, rotation: str) -> str:
    """An acceleration, a position or a rotation of {mass}."""
    if name.startswith("a_"):
        return f"acceleration of {{mass}} along {name[2:]}"
    if name.startswith("omegadot_"):
        axis = name.removeprefix("omegadot_")
        return f"angular acceleration of {{mass}} about {_TURNS_ABOUT.get(axis, axis)}"
    if name in ANGLES:
        return rotation.format(ANGLES[name])
    return f"position of {{mass}} along {name} in its housing"


def _masses(names: Sequence[str]) -> str:
    """`test mass 1`, `test masses 1 and 2`; those of other names keep them."""
    numbers = [re.fullmatch(r"TM(\d+)", name) for name in names]
    said = [m[1] if m else name for m, name in zip(numbers, names, strict=True)]
    return f"test mass{'es' * (len(said) > 1)} {and_text(said)}"


def at_rest_title(quantity: str, *places: str) -> str:
    """Plain title of a judged quantity of the field at rest, on one test mass or several, or the difference TM2-TM1."""
    if not quantity.startswith("gamma_"):
        return outputs_title(["-".join(f"{name}_{quantity}" for name in place.split("-")) for place in places])
    title = f"gravity gradient {quantity.removeprefix('gamma_')} on "
    if any("-" in place for place in places):
        return and_text([title + " minus that on ".join(_masses([n]) for n in place.split("-")) for place in places])
    return title + _masses(places)


def by_subsystem(name: str) -> str:
    """Whose field at rest it is, in a sentence: `the inertial sensor`, `everything in the model`."""
    if name == ALL:
        return "everything in the model"
    parts = [SUBSYSTEM_TITLES.get(part, part) for part in name.split("+")]
    return f"{and_text(parts)} together" if len(parts) > 1 else f"the {parts[0]}"


def subsystem_label(name: str) -> str:
    """The same behind its name: `IS: inertial sensor`, `IS+LTP: both together`, or the name alone."""
    if name == ALL:
        return f"{ALL}: everything in the model"
    if "+" in name:
        return f"{name}: {'both' if name.count('+') == 1 else 'all of them'} together"
    return f"{name}: {SUBSYSTEM_TITLES[name]}" if name in SUBSYSTEM_TITLES else name


def at_rest_requirement(name: str) -> str:
    """Plain title of a requirement on the field at rest; one of the configuration is its own."""
    return AT_REST_PRESETS[name].title if name in AT_REST_PRESETS else name


def mass_title(test_mass: str) -> str:
    """`test mass 1` for TM1; another name is kept."""
    return _masses([test_mass])


def requirement_title(name: str, own: Mapping[str, str]) -> str:
    """Plain title of a requirement: its `own` in the configuration, or the preset's; else its name."""
    return own.get(name) or (PRESETS[name].title if name in PRESETS else name)
