"""The thermal model's file: network, frequencies, disturbances, their correlations, outputs, the map on the model."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, model_validator

from tedm_cli.arrays import FloatArray
from tedm_cli.config.base import (
    IDENTIFIER,
    Bounded,
    Coefficient,
    FileName,
    Frequency,
    Strict,
    TemperatureLevel,
    load,
    named_by_project,
)
from tedm_cli.config.cases import FrequencyTable
from tedm_cli.config.temperature.spectrum import SpectrumChoice
from tedm_cli.config.thermal.map import MapTable
from tedm_cli.files.provenance import ConfigFile
from tedm_cli.noise.requirements import frequency_grid
from tedm_cli.noise.temperature import Spectrum, TabulatedSpectrum
from tedm_cli.quantities import FREQUENCY, GRID_POINTS, NOISE_LEVEL, POWER_ASD, POWER_SHARE, TIME_STAMP
from tedm_cli.tables.csv_table import read_table
from tedm_cli.thermal.linear import TEMPERATURE, Place

NodeName = Annotated[str, Field(min_length=1)]
Nodes = Annotated[list[NodeName], Field(min_length=1)]


class NetworkTable(Strict):
    """The thermal network: nodes, conductors and constant powers in CSV tables, or in one file of ESATAN-TMS."""

    nodes: FileName | None = Field(
        default=None,
        description="A CSV `node,capacity_J_K,kind,temperature_K`, which `x_m,y_m,z_m` may follow. `kind` is "
        "diffusive, arithmetic (of capacity 0) or boundary. The column `temperature_degC` may stand in place of "
        "`temperature_K`. An empty temperature is solved for; one that is given is kept.",
    )
    conductors: FileName | None = Field(
        default=None,
        description="A CSV `node_a,node_b,GL_W_K,GR_m2`: heat GL (Ta - Tb) + sigma GR (Ta^4 - Tb^4) flows from a to b.",
    )
    powers: FileName | None = Field(
        default=None, description="A CSV `node,power_W` of constant powers. Without it there are none."
    )
    tmd: FileName | None = Field(
        default=None, description="An ESATAN-TMS file `.TMD` (HDF5) in place of the CSV tables."
    )
    time_s: Annotated[float, Bounded(TIME_STAMP)] | None = Field(
        default=None, description="Which of the times of a TMD file counts. Else the last."
    )
    unit: Literal["K", "degC"] | None = Field(
        default=None, description="Unit of the temperatures of a TMD file that has no offset (its attribute `TAbs`)."
    )
    temperatures: Literal["keep", "start"] = Field(
        default="keep",
        description="Whether temperatures of diffusive and arithmetic nodes that are given are kept, or the steady "
        "state is solved for from there. Those of boundaries are always kept.",
    )

    @model_validator(mode="after")
    def _one_source(self) -> NetworkTable:
        csv = [key for key in ("nodes", "conductors", "powers") if getattr(self, key) is not None]
        if self.tmd is None and (idle := [key for key in ("time_s", "unit") if getattr(self, key) is not None]):
            raise ValueError(f"has no tmd, but {', '.join(idle)} given")
        if self.tmd is not None and csv:
            raise ValueError(f"has both tmd and {', '.join(csv)}")
        if self.tmd is None and (self.nodes is None or self.conductors is None):
            raise ValueError("needs nodes and conductors, or tmd")
        return self

    def file_names(self) -> list[str]:
        """The files that it names."""
        return [name for name in (self.nodes, self.conductors, self.powers, self.tmd) if name is not None]


class ThermalFrequencyTable(FrequencyTable):
    """The frequencies of gains and spectra, as a grid or a list. Without this table they are those of the cases."""

    points: Annotated[int, Bounded(GRID_POINTS)] = Field(
        default=301, description="Number of frequencies, evenly spaced in the logarithm. 1 mHz is added."
    )
    list_hz: Annotated[list[Frequency], Field(min_length=1, max_length=100_000)] | None = Field(
        default=None, description="The frequencies, ascending, in place of a grid."
    )

    def frequency_hz(self) -> FloatArray:
        """[F] in Hz."""
        if self.list_hz is not None:
            return np.array(self.list_hz)
        return frequency_grid(self.min_hz, self.max_hz, self.points, [])

    @model_validator(mode="after")
    def _ascending(self) -> ThermalFrequencyTable:
        found = self.list_hz or []
        if found and (idle := sorted(self.model_fields_set - {"list_hz"})):
            raise ValueError(f"has list_hz, but {', '.join(idle)} given")
        falls = next((n for n, (a, b) in enumerate(pairwise(found)) if b <= a), None)
        if falls is not None:
            raise ValueError(f"list_hz: {found[falls + 1]:g} Hz is not above {found[falls]:g} Hz before it")
        return self


class DisturbanceTable(SpectrumChoice):
    """A temperature of boundaries that varies, or a power: where it acts, and its spectrum."""

    name: Annotated[str, Field(pattern=IDENTIFIER)] = Field(description="Name of the disturbance.")
    nodes: Nodes = Field(
        description="Where it acts: the boundaries that all have this temperature, or the nodes that share the power."
    )
    weights: Annotated[list[Annotated[float, Bounded(POWER_SHARE)]], Field(min_length=1)] | None = Field(
        default=None,
        description="Shares of the power by node, as many as `nodes`; they sum to 1. Else all have the same share.",
    )
    kind: Literal["temperature", "power"] = Field(description="What varies.")
    level_K: TemperatureLevel | None = Field(
        default=None, description='Level of a temperature by "thesis" or "white", which need it, in K/sqrt(Hz).'
    )
    level_W: Annotated[float, Bounded(POWER_ASD)] | None = Field(
        default=None, description='Level of a power by "thesis" or "white", which need it, in W/sqrt(Hz).'
    )
    table: FileName | None = Field(
        default=None,
        description="A CSV `frequency_hz,amplitude` in K or W per sqrt(Hz), straight between its points on logarithmic "
        "axes. `preset` may be left out with it.",
    )

    @model_validator(mode="before")
    @classmethod
    def _a_table_is_a_preset(cls, given: Any) -> Any:
        if isinstance(given, dict) and "table" in given and "preset" not in given:
            return {**given, "preset": "table"}
        return given

    def place(self) -> Place:
        """Where it acts, and the share of each node."""
        equal = 1.0 if self.kind == TEMPERATURE else 1.0 / len(self.nodes)
        share = tuple(self.weights) if self.weights is not None else (equal,) * len(self.nodes)
        return Place(self.kind, tuple(self.nodes), share)

    def implausible(self, low_hz: float, high_hz: float) -> str:
        """What makes its low-pass implausible between two frequencies; empty where nothing does."""
        if self.kind == TEMPERATURE:
            return self.filter_fact(self.level_K or 0.0, low_hz, high_hz)
        return self.filter_fact(self.level_W or 0.0, low_hz, high_hz, POWER_ASD)

    def own_spectrum(self, path_of: Callable[[str], Path]) -> Spectrum:
        """Its spectrum; `InputError` for its table, which is where `path_of` says."""
        if self.table is None:
            level = self.level_K if self.kind == TEMPERATURE else self.level_W
            return self.spectrum(level or 0.0)
        path = path_of(self.table)
        rows = read_table(path, {"frequency_hz": FREQUENCY, "amplitude": NOISE_LEVEL})
        frequency, amplitude = (np.array([row.number[c] for row in rows]) for c in ("frequency_hz", "amplitude"))
        return TabulatedSpectrum.of(frequency, amplitude, str(path))

    @model_validator(mode="after")
    def _fits_its_kind(self) -> DisturbanceTable:
        own, other = ("level_K", "level_W") if self.kind == "temperature" else ("level_W", "level_K")
        facts = []
        if getattr(self, other) is not None:
            facts.append(f"{other} is given, but kind is {self.kind}: give {own}")
        elif self.preset in ("thesis", "white") and getattr(self, own) is None:
            facts.append(f"preset {self.preset} needs {own}")
        elif self.preset in ("lpf_flight", "table") and getattr(self, own) is not None:
            facts.append(f"preset {self.preset} has its own levels, but {own} given")
        if self.preset == "lpf_flight" and self.kind == "power":
            facts.append("preset lpf_flight is in K/sqrt(Hz) and cannot be used for powers")
        if twice := sorted({node for node in self.nodes if self.nodes.count(node) > 1}):
            facts.append(f"node {twice[0]!r} is there twice")
        if self.weights is not None:
            if self.kind == "temperature":
                facts.append("weights share a power; a temperature is the same on all its nodes")
            elif len(self.weights) != len(self.nodes):
                facts.append(f"{len(self.weights)} weights for {len(self.nodes)} nodes")
            elif abs(sum(self.weights) - 1.0) > 1e-9:
                facts.append(f"weights sum to {sum(self.weights):.10g}, not to 1")
        if facts:
            raise ValueError("; ".join(facts))
        return self


class DisturbanceCorrelationTable(Strict):
    """The correlation of some disturbances, each with each; what no table names is uncorrelated."""

    disturbances: Annotated[list[str], Field(min_length=2)] = Field(description="Names of the disturbances.")
    rho: Coefficient = Field(description="Correlation coefficient of each pair of them.")

    @model_validator(mode="after")
    def _each_once(self) -> DisturbanceCorrelationTable:
        if twice := sorted({n for n in self.disturbances if self.disturbances.count(n) > 1}):
            raise ValueError(f"disturbance {twice[0]!r} is there twice")
        return self


class ThermalOutputTable(Strict):
    """Of which nodes a large network's gains and spectra are kept."""

    nodes: Nodes = Field(
        description="Free nodes (diffusive or arithmetic) whose gains and spectra are kept where the network has more "
        "than 200. Else all gains are, and no spectra."
    )

    @model_validator(mode="after")
    def _each_once(self) -> ThermalOutputTable:
        if twice := sorted({n for n in self.nodes if self.nodes.count(n) > 1}):
            raise ValueError(f"node {twice[0]!r} is there twice")
        return self


class ThermalConfig(Strict):
    """Network, frequencies, disturbances, correlations, outputs, map. All may be left out.

    Paths are relative to this file; `{build_dir}` in a path stands for the build folder.
    """

    network: NetworkTable | None = Field(default=None, description="The network. Without it there is the map alone.")
    frequency: ThermalFrequencyTable | None = Field(
        default=None, description="The frequencies. Else those of the cases file."
    )
    disturbances: list[DisturbanceTable] = Field(
        alias="disturbance", default_factory=list, description="What disturbs the network."
    )
    correlations: list[DisturbanceCorrelationTable] = Field(
        alias="correlation", default_factory=list, description="Correlations of the disturbances."
    )
    output: ThermalOutputTable | None = Field(default=None, description="Nodes of a large network that are kept.")
    map: MapTable | None = Field(
        default=None, description="How thermal nodes lie on the finite elements. Without it sensitivities are left out."
    )

    @model_validator(mode="after")
    def _known_disturbances(self) -> ThermalConfig:
        names = [d.name for d in self.disturbances]
        if twice := sorted({n for n in names if names.count(n) > 1}):
            raise ValueError(f"disturbance {twice[0]} is there twice")
        pairs: dict[frozenset[str], int] = {}
        for k, table in enumerate(self.correlations):
            unknown = next((n for n in table.disturbances if n not in names), None)
            if unknown is not None:
                raise ValueError(
                    f"correlation[{k}]: no disturbance is called {unknown!r}; there are {', '.join(names)}"
                )
            for i, a in enumerate(table.disturbances):
                for b in table.disturbances[:i]:
                    if (other := pairs.setdefault(frozenset((a, b)), k)) != k:
                        raise ValueError(f"correlation[{k}]: {b} and {a} have a correlation already, in [{other}]")
        return self

    def correlation(self) -> FloatArray:
        """[u, u], of the disturbances in the order of the file; not yet checked."""
        rows = {d.name: row for row, d in enumerate(self.disturbances)}
        found = np.eye(len(rows))
        for table in self.correlations:
            for a in table.disturbances:
                for b in table.disturbances:
                    if a != b:
                        found[rows[a], rows[b]] = table.rho
        return found

    def file_names(self) -> list[str]:
        """Files beside this one that the network and its disturbances are read from; those of the map are its own."""
        network = [] if self.network is None else self.network.file_names()
        tables = [d.table for d in self.disturbances if d.table is not None]
        return list(dict.fromkeys([*network, *tables]))


def load_thermal(path: Path) -> tuple[ConfigFile, ThermalConfig]:
    """Read a thermal model's file; `ConfigError` lists all problems."""
    return load(ThermalConfig, path, hint=named_by_project("thermal"))
