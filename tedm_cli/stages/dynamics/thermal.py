"""The temperatures of a case as the loop feels them: S on the test masses and N on the read-outs, of one ΔT."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.config.model.file import load_model
from tedm_cli.config.optics.against_model import LARGEST_ANGLE_RAD
from tedm_cli.config.optics.layout import load_layout
from tedm_cli.config.project import Project
from tedm_cli.contracts import OPTICS as OPTICS_KIND
from tedm_cli.contracts import SENSITIVITY as SENSITIVITY_KIND
from tedm_cli.dynamics.signals import COORDINATES, STRAY, TEST_MASSES
from tedm_cli.dynamics.thermal_input import AnyThermal, NetworkInput, ThermalInput
from tedm_cli.errors import ConfigError, InputError, PhysicsError
from tedm_cli.files.build_folder import (
    DISTORTION_FILE,
    OPTICS_FILE,
    SENSITIVITY_FILE,
    require_configuration,
    require_same_areas,
    require_same_input,
)
from tedm_cli.files.store import open_checked
from tedm_cli.noise.areas import AreaTable
from tedm_cli.noise.network import NetworkNoise
from tedm_cli.noise.sources import AnySource
from tedm_cli.results.adjoint.within import Gradients, and_numbers
from tedm_cli.results.areas import read_areas
from tedm_cli.results.cases.effects import effect_files, read_effects
from tedm_cli.results.gravity.self_gravity import read_self_gravity
from tedm_cli.results.optics import read_read_outs
from tedm_cli.results.outputs import ModelOutputs
from tedm_cli.results.thermal.case import ThermalColumns

_AXES = LARGEST_ANGLE_RAD  # of a test mass in the layout against those in the model: more are two test masses


@dataclass(frozen=True, eq=False)
class ThermalRows:
    """Accelerations [12, k] of the test masses and read-outs [15, k] per kelvin of the k areas, the user's own
    effects with them.

    acceleration_label [12], read_out_label [15] : the outputs of sensitivity.h5 and optics.h5 that they are; empty
    where there is none.
    """

    areas: AreaTable
    area_id: IntArray
    acceleration: FloatArray
    read_out: FloatArray
    set_name: str
    acceleration_label: list[str]
    read_out_label: list[str]

    def by(self, outputs: ModelOutputs) -> ThermalRows:
        """The same by the columns that outputs have, thermal nodes for instance."""
        by_label = {"": np.zeros(len(outputs.areas)), **dict(zip(outputs.labels, outputs.rows, strict=True))}
        return replace(
            self,
            areas=outputs.areas,
            area_id=outputs.area_id,
            acceleration=np.stack([by_label[label] for label in self.acceleration_label]),
            read_out=np.stack([by_label[label] for label in self.read_out_label]),
        )

    def with_gradients(self, more: Gradients | None) -> ThermalRows:
        """With gradients within areas behind the model's areas."""
        if more is None:
            return self
        silent = np.zeros(len(more.areas))
        by_label = {"": silent, **more.rows}
        return replace(
            self,
            areas=self.areas.and_last(more.areas),
            area_id=and_numbers(self.area_id, len(more.areas)),
            acceleration=np.hstack([self.acceleration, [by_label[label] for label in self.acceleration_label]]),
            read_out=np.hstack([self.read_out, [by_label[label] for label in self.read_out_label]]),
        )

    def of_network(self, columns: ThermalColumns) -> ThermalRows:
        """The same of the columns of a case of the thermal network, in place of the model's areas."""
        outputs = columns.outputs
        by_label = dict(zip(outputs.labels, outputs.rows, strict=True)) | {"": np.zeros(len(outputs.areas))}
        return replace(
            self,
            areas=outputs.areas,
            area_id=outputs.area_id,
            acceleration=np.array([by_label[label] for label in self.acceleration_label]),
            read_out=np.array([by_label[label] for label in self.read_out_label]),
        )

    def driven_by(self, source: AnySource, frequency_hz: FloatArray) -> AnyThermal:
        """The noise input of a case at `frequency_hz` [F]; delays turn phases, as in `noise.propagation`."""
        if isinstance(source, NetworkNoise):
            there = source.at(frequency_hz)
            return NetworkInput(self.acceleration, self.read_out, there.driven, there.disturbances, there.factor)
        correlation = source.correlation
        amplitude = source.temperature.amplitudes(frequency_hz) * np.exp(
            -2j * np.pi * correlation.delay_s[:, None] * frequency_hz
        )
        if not correlation.delay_s.any():
            amplitude = amplitude.real
        return ThermalInput(self.acceleration, self.read_out, correlation.factor, amplitude)


def thermal_rows(project: Project, wanted_set: str | None) -> ThermalRows:
    """S and N of a project with the effects of the user's own, in the order of the loop.

    Raises
    ------
    InputError : files of different distortion matrices or areas, or of other configurations than the project's now;
        sensitivities that are not finite; a table of effects that does not fit.
    PhysicsError : a test mass whose read-outs are along other axes than its accelerations.
    """
    layout_file = project.required_optics()
    _, layout = load_layout(layout_file)
    s_path, o_path = project.build_dir / SENSITIVITY_FILE, project.build_dir / OPTICS_FILE
    with open_checked(s_path, SENSITIVITY_KIND) as s, open_checked(o_path, OPTICS_KIND) as o:
        require_same_input(DISTORTION_FILE, s, o)
        require_same_areas(s, o)
        require_configuration(s, project.model)
        require_configuration(o, layout_file)
        areas = read_areas(s)
        names = dict(zip(s.strings(SENSITIVITY_KIND.TEST_MASS_NAME), TEST_MASSES, strict=True))
        axes = s.array(SENSITIVITY_KIND.TEST_MASS_AXES)
        measured = dict(zip((e.name for e in layout.test_masses), layout.test_mass_axes_basic, strict=True))
        for i, name in enumerate(names):
            off = float(np.abs(axes[i] - measured.get(name, axes[i])).max())
            if off > _AXES:
                raise PhysicsError(
                    f"{name} has other axes in the optical layout than in the model (they differ by {off:.2g}):"
                    " the read-outs are not along the axes of the loop",
                    where=str(layout_file),
                    hint=f"give `axes` to the element {name}, in the layout frame, or turn those of [[test_mass]]",
                )
        k = len(areas)
        acceleration, read_out = np.zeros((len(STRAY), k)), np.zeros((len(COORDINATES), k))
        labels = [""] * len(STRAY), [""] * len(COORDINATES)
        gravity, read_outs = read_self_gravity(s), read_read_outs(o)
        chosen = _chosen(read_outs.sets, wanted_set, project)
        model = load_model(project.model)[1]
        all_labels = (*gravity.label, *read_outs.names)
        units = [u.removesuffix("/K") for u in gravity.unit] + read_outs.unit * len(read_outs.sets)
        effects = dict(zip(all_labels, read_effects(project, model, all_labels, units, areas).total, strict=True))
        for label, row in zip(gravity.label, gravity.S, strict=True):
            name, _, rest = label.partition("_")
            place = STRAY.index(f"{names[name]}_{rest}")
            acceleration[place], labels[0][place] = row + effects[label], label
        for label, row in zip(read_outs.label, read_outs.N[chosen], strict=True):
            name, _, rest = label.rpartition("_")
            if name in names:
                place, whole = COORDINATES.index(f"{names[name]}_{rest}"), f"{chosen}_{label}"
                read_out[place], labels[1][place] = row + effects[whole], whole
        for what, rows in ((f"{s_path}: /S", acceleration), (f"{o_path}: /N/{chosen}", read_out)):
            if not np.isfinite(rows).all():
                raise InputError("has values that are not finite", where=what)
        return ThermalRows(areas, s.array(SENSITIVITY_KIND.AREA_ID), acceleration, read_out, chosen, *labels)


def own_effects(project: Project) -> list[Path]:
    """The tables of effects of the user's own, which the loop feels too."""
    return effect_files(project, load_model(project.model)[1])


def _chosen(sets: list[str], wanted: str | None, project: Project) -> str:
    if wanted is None:
        return sets[0]
    if wanted not in sets:
        fact = f"no set of photodiodes is called {wanted!r}; there are {', '.join(sets)}"
        raise ConfigError([("read_out.set", fact)], where=str(project.dynamics))
    return wanted
