"""What thermal.h5 says of the network: its steady state, gains, and the low-pass that fits each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.config.project import Project
from tedm_cli.config.thermal.file import ThermalConfig
from tedm_cli.contracts import THERMAL
from tedm_cli.files.build_folder import ADJOINT_FILE, require_configuration, require_input
from tedm_cli.files.provenance import input_files
from tedm_cli.files.store import Reader
from tedm_cli.noise.temperature import REFERENCE_HZ
from tedm_cli.thermal.low_pass import within
from tedm_cli.thermal.spectra import coherence


@dataclass(frozen=True)
class Spread:
    """A quantity over the nodes: its median, least and greatest value."""

    median: float
    low: float
    high: float


@dataclass(frozen=True)
class DisturbanceResults:
    """A disturbance and its gains.

    kind : temperature or power. spectrum : in words. largest : the nodes with the largest gains for f → 0, with these,
    K/K or K/W. order, corner_hz : of the low-pass that fits each gain best, None where there is none. error : median of
    its root mean square error in ln |H|. beyond : number of nodes whose corner is beyond the frequencies, which the
    spread leaves out.
    """

    name: str
    kind: str
    spectrum: str
    largest: tuple[tuple[str, float], ...]
    order: Spread | None
    corner_hz: Spread | None
    error: float | None
    beyond: int


@dataclass(frozen=True)
class SteadyResults:
    """The steady state.

    count : of nodes, by kind. conductors : their number, `radiating` of them by radiation. solved, given : number of
    nodes without boundaries whose temperature was solved for, or given. coldest, hottest : node and K. power_W : sum of
    all powers. to_boundaries_W : heat that the boundaries take. imbalance_W : largest of nodes solved for; held_W :
    largest of those given, with `held`, its node.
    """

    count: dict[str, int]
    conductors: int
    radiating: int
    solved: int
    given: int
    coldest: tuple[str, float]
    hottest: tuple[str, float]
    power_W: float
    to_boundaries_W: float
    imbalance_W: float
    held: str
    held_W: float


@dataclass(frozen=True)
class CoherenceResults:
    """|S_ij|² / (S_ii S_jj) of all pairs of nodes at the frequency nearest to 1 mHz: its median, and the least with its
    pair."""

    frequency_hz: float
    median: float
    least: float
    pair: tuple[str, str]


@dataclass(frozen=True)
class ThermalResults:
    """What the file holds; None and empty where it has none of it.

    kept : nodes whose gains are in the file. frequencies : number, lowest and highest in Hz. spectra : whether the
    spectra of these nodes are in the file. coherence : of two such nodes or more. mapped : nodes that lie on the model.
    outputs : number of rows that have sensitivities to them.
    """

    steady: SteadyResults | None
    kept: int
    frequencies: tuple[int, float, float] | None
    spectra: bool
    coherence: CoherenceResults | None
    disturbances: tuple[DisturbanceResults, ...]
    mapped: tuple[str, ...]
    outputs: int


def read_thermal(file: Reader) -> ThermalResults:
    """What an open thermal.h5 says."""
    mapped = file.has(THERMAL.MAP_NODE)
    frequency = file.array(THERMAL.FREQUENCY) if file.has(THERMAL.FREQUENCY) else None
    return ThermalResults(
        steady=_steady(file) if file.has(THERMAL.NODE_NAME) else None,
        kept=len(file.array(THERMAL.NODE_FREE)) if file.has(THERMAL.NODE_FREE) else 0,
        frequencies=None if frequency is None else (len(frequency), float(frequency[0]), float(frequency[-1])),
        spectra=file.has(THERMAL.PSD),
        coherence=None if frequency is None or not file.has(THERMAL.PSD) else _coherence(file, frequency),
        disturbances=() if frequency is None else _disturbances(file, frequency),
        mapped=tuple(file.strings(THERMAL.MAP_NODE)) if mapped else (),
        outputs=len(file.strings(THERMAL.ROW_LABEL)) if file.has(THERMAL.ROW_LABEL) else 0,
    )


def require_thermal(file: Reader, project: Project, config: ThermalConfig) -> None:
    """Refuse thermal.h5 made from other files than the project's thermal model names, or from another adjoint."""
    require_network(file, project, config)
    where = project.required_thermal()
    names = () if config.map is None else config.map.file_names()
    _require_inputs(file, [*(project.beside(where, name) for name in names), project.build_dir / ADJOINT_FILE])


def require_network(file: Reader, project: Project, config: ThermalConfig) -> None:
    """Refuse thermal.h5 whose network is from other files than the project's thermal model names."""
    where = project.required_thermal()
    require_configuration(file, where)
    _require_inputs(file, [project.beside(where, name) for name in config.file_names()])


def _require_inputs(file: Reader, paths: Sequence[Path]) -> None:
    """Refuse a file made from other versions of what is there of `paths`."""
    for used in input_files([path for path in paths if path.exists()]):
        require_input(file, used)


def _coherence(file: Reader, frequency: FloatArray) -> CoherenceResults | None:
    nearest = int(np.argmin(np.abs(np.log(frequency / REFERENCE_HZ))))
    psd = file.dataset(THERMAL.PSD)[nearest : nearest + 1]
    one, other = np.triu_indices(psd.shape[1], 1)
    if not len(one):
        return None
    found = np.abs(coherence(psd)[0, one, other]) ** 2
    least, node = int(np.argmin(found)), file.strings(THERMAL.NODE_FREE_NAME)
    pair = node[one[least]], node[other[least]]
    return CoherenceResults(float(frequency[nearest]), float(np.median(found)), float(found[least]), pair)


def _steady(file: Reader) -> SteadyResults:
    name, kind = file.strings(THERMAL.NODE_NAME), np.array(file.strings(THERMAL.NODE_KIND))
    temperature, net = file.array(THERMAL.STEADY_K), file.array(THERMAL.NODE_NET_HEAT)
    boundary, solved = kind == "boundary", file.array(THERMAL.NODE_SOLVED) == 1
    given = ~boundary & ~solved
    cold, hot = int(np.argmin(temperature)), int(np.argmax(temperature))
    held = int(np.argmax(np.where(given, np.abs(net), -1.0)))
    return SteadyResults(
        count={k: int((kind == k).sum()) for k in ("diffusive", "arithmetic", "boundary")},
        conductors=len(file.array(THERMAL.CONDUCTOR_A)),
        radiating=int((file.array(THERMAL.CONDUCTOR_GR) > 0.0).sum()),
        solved=int(solved.sum()),
        given=int(given.sum()),
        coldest=(name[cold], float(temperature[cold])),
        hottest=(name[hot], float(temperature[hot])),
        power_W=float(file.array(THERMAL.NODE_POWER).sum()),
        to_boundaries_W=float(net[boundary].sum()),
        imbalance_W=float(np.max(np.abs(net[solved]), initial=0.0)),
        held=name[held] if given.any() else "",
        held_W=float(net[held]) if given.any() else 0.0,
    )


def _disturbances(file: Reader, frequency: FloatArray) -> tuple[DisturbanceResults, ...]:
    node = file.strings(THERMAL.NODE_FREE_NAME)
    static, order = file.array(THERMAL.STATIC_GAIN), file.array(THERMAL.FILTER_ORDER)
    corner, error = file.array(THERMAL.FILTER_CORNER), file.array(THERMAL.FILTER_ERROR)
    words = (
        file.strings(d) for d in (THERMAL.DISTURBANCE_NAME, THERMAL.DISTURBANCE_KIND, THERMAL.DISTURBANCE_SPECTRUM)
    )
    found = []
    for column, (name, kind, spectrum) in enumerate(zip(*words, strict=True)):
        fits = np.isfinite(order[:, column])
        inside = within(corner[:, column], frequency)
        largest = np.argsort(-np.abs(static[:, column]), kind="stable")[:3]
        found.append(
            DisturbanceResults(
                name,
                kind,
                spectrum,
                tuple((node[i], float(static[i, column])) for i in largest),
                _spread(order[inside, column]),
                _spread(corner[inside, column]),
                float(np.median(error[fits, column])) if fits.any() else None,
                int((fits & ~inside).sum()),
            )
        )
    return tuple(found)


def _spread(values: FloatArray) -> Spread | None:
    return Spread(float(np.median(values)), float(values.min()), float(values.max())) if len(values) else None
