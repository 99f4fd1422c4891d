"""thermal.h5: the thermal network, its gains and spectra; outputs per kelvin of thermal nodes."""

from __future__ import annotations

from tedm_cli.contracts.node_displacements import NodeDisplacements
from tedm_cli.contracts.spec import BASIC, FLAG, NAMES, Dataset, FileKind, Values

KINDS_OF_NODE = ("diffusive", "arithmetic", "boundary")
KINDS_OF_DISTURBANCE = ("temperature", "power")
_NETWORK, _DISTURBED, _MAPPED, _PLACED, _WARMED = "network", "disturbed", "mapped", "placed", "warmed"


class ThermalFile(NodeDisplacements, FileKind):
    """Its datasets by name; `THERMAL` is the kind of file."""

    NODE_NAME = Dataset(
        "/node/name",
        ("node",),
        "str",
        "1",
        "nodes of the network",
        optional=True,
        values=NAMES,
        group=_NETWORK,
    )
    NODE_KIND = Dataset(
        "/node/kind",
        ("node",),
        "str",
        "1",
        "with a heat capacity, without, or of a temperature that the network does not change",
        optional=True,
        values=Values(words=KINDS_OF_NODE),
        group=_NETWORK,
    )
    NODE_CAPACITY = Dataset(
        "/node/capacity", ("node",), "float", "J/K", "heat capacity; 0 of boundaries", optional=True, group=_NETWORK
    )
    NODE_POWER = Dataset(
        "/node/power", ("node",), "float", "W", "constant power put into the node", optional=True, group=_NETWORK
    )
    NODE_NET_HEAT = Dataset(
        "/node/net_heat",
        ("node",),
        "float",
        "W",
        "heat from conductors and power in the steady state: rounding where solved for; of a boundary what it takes",
        optional=True,
        group=_NETWORK,
    )
    STEADY_K = Dataset(
        "/steady_K", ("node",), "float", "K", "temperature in the steady state", optional=True, group=_NETWORK
    )
    NODE_SOLVED = Dataset(
        "/node/solved",
        ("node",),
        "int",
        "1",
        "1: the temperature was solved for, 0: it was given",
        optional=True,
        values=FLAG,
        group=_NETWORK,
    )
    NODE_POSITION = Dataset(
        "/node/position",
        ("node", "xyz"),
        "float",
        "m",
        "where the node is, as the network tells it; nan: not told",
        BASIC,
        optional=True,
        open_ended=True,
        group="position",
    )
    CONDUCTOR_A = Dataset(
        "/conductor/node_a",
        ("conductor",),
        "int",
        "1",
        "node that heat flows from",
        optional=True,
        values=Values(rows_of="node"),
        group=_NETWORK,
    )
    CONDUCTOR_B = Dataset(
        "/conductor/node_b",
        ("conductor",),
        "int",
        "1",
        "node that heat flows to",
        optional=True,
        values=Values(rows_of="node"),
        group=_NETWORK,
    )
    CONDUCTOR_GL = Dataset(
        "/conductor/GL", ("conductor",), "float", "W/K", "linear conductance", optional=True, group=_NETWORK
    )
    CONDUCTOR_GR = Dataset(
        "/conductor/GR", ("conductor",), "float", "m^2", "radiative conductance", optional=True, group=_NETWORK
    )
    NODE_FREE = Dataset(
        "/node/free",
        ("free",),
        "int",
        "1",
        "nodes of the gains: all diffusive and arithmetic ones, or those chosen of a large network",
        optional=True,
        values=Values(rows_of="node"),
        group=_NETWORK,
    )
    NODE_FREE_NAME = Dataset(
        "/node/free_name",
        ("free",),
        "str",
        "1",
        "the names of these nodes",
        optional=True,
        values=NAMES,
        group=_NETWORK,
    )
    DISTURBANCE_NAME = Dataset(
        "/disturbance/name",
        ("disturbance",),
        "str",
        "1",
        "disturbances",
        optional=True,
        values=NAMES,
        group=_DISTURBED,
    )
    DISTURBANCE_KIND = Dataset(
        "/disturbance/kind",
        ("disturbance",),
        "str",
        "1",
        "a temperature (K) of boundaries, or a power (W)",
        optional=True,
        values=Values(words=KINDS_OF_DISTURBANCE),
        group=_DISTURBED,
    )
    DISTURBANCE_SPECTRUM = Dataset(
        "/disturbance/spectrum",
        ("disturbance",),
        "str",
        "1",
        "spectrum in words",
        optional=True,
        group=_DISTURBED,
    )
    DISTURBANCE_SHARE = Dataset(
        "/disturbance/share",
        ("disturbance", "node"),
        "float",
        "1",
        "share of the power of each node; 1 at boundaries of the temperature",
        optional=True,
        group=_DISTURBED,
    )
    DISTURBANCE_ASD = Dataset(
        "/disturbance/asd",
        ("disturbance", "frequency"),
        "float",
        "K/sqrt(Hz) or W/sqrt(Hz)",
        "amplitude spectral density",
        optional=True,
        group=_DISTURBED,
    )
    DISTURBANCE_CORRELATION = Dataset(
        "/disturbance/correlation",
        ("disturbance", "disturbance_column"),
        "float",
        "1",
        "correlation of the disturbances, the same at all frequencies",
        optional=True,
        group=_DISTURBED,
    )
    FREQUENCY = Dataset("/frequency", ("frequency",), "float", "Hz", "frequencies", optional=True, group=_DISTURBED)
    TRANSFER = Dataset(
        "/transfer",
        ("frequency", "free", "disturbance"),
        "complex",
        "K/K or K/W",
        "gain from each disturbance to each node; time dependence exp(+2 pi i f t)",
        optional=True,
        group=_DISTURBED,
    )
    STATIC_GAIN = Dataset(
        "/static_gain",
        ("free", "disturbance"),
        "float",
        "K/K or K/W",
        "the same for f to 0",
        optional=True,
        group=_DISTURBED,
    )
    FILTER_ORDER = Dataset(
        "/filter/order",
        ("free", "disturbance"),
        "float",
        "1",
        "order n of the low-pass 1/sqrt(1 + (f/fc)^2n) that fits the gain best; nan: no gain",
        optional=True,
        open_ended=True,
        group=_DISTURBED,
    )
    FILTER_CORNER = Dataset(
        "/filter/corner_hz",
        ("free", "disturbance"),
        "float",
        "Hz",
        "its corner frequency; one at the end of what is searched is beyond the frequencies; nan: no gain",
        optional=True,
        open_ended=True,
        group=_DISTURBED,
    )
    FILTER_ERROR = Dataset(
        "/filter/error",
        ("free", "disturbance"),
        "float",
        "1",
        "root mean square of ln(fit / gain) over the frequencies, at most 64 of them; nan: no gain",
        optional=True,
        open_ended=True,
        group=_DISTURBED,
    )
    PSD = Dataset(
        "/psd",
        ("frequency", "free", "free_column"),
        "complex",
        "K^2/Hz",
        "one-sided cross-spectral densities of the nodes; absent of more than 200 nodes",
        optional=True,
    )
    ROW_LABEL = Dataset("/row/label", ("row",), "str", "1", "outputs", optional=True, values=NAMES, group=_MAPPED)
    ROW_UNIT = Dataset("/row/unit", ("row",), "str", "1", "unit of each row", optional=True, group=_MAPPED)
    MAP_NODE = Dataset(
        "/map/node",
        ("map_node",),
        "str",
        "1",
        "thermal nodes that lie on the finite elements",
        optional=True,
        values=NAMES,
        group=_PLACED,
    )
    MAP_AREA = Dataset(
        "/map/area",
        ("map_node",),
        "str",
        "1",
        "thermal area that most of the node's volume is in, or with weights that has most of it; empty: none",
        optional=True,
        group=_PLACED,
    )
    SENSITIVITY = Dataset(
        "/sensitivity",
        ("row", "map_node"),
        "float",
        None,
        "outputs per kelvin of each of these nodes",
        optional=True,
        group=_MAPPED,
    )
    MAP_GRID = Dataset(
        "/map/grid_id",
        ("grid",),
        "int",
        "1",
        "grids of the model, of what is on them",
        optional=True,
        values=Values(ascending=True, least=1),
        group="grids",
    )
    MAP_STEADY_K = Dataset(
        "/map/steady_K",
        ("grid",),
        "float",
        "K",
        "temperature of the grids in the steady state, by conduction between the nodes; nan: not mapped",
        optional=True,
        open_ended=True,
        group=_WARMED,
    )


THERMAL = ThermalFile("thermal", 1, "tedm build-thermal")
