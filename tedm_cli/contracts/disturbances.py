"""What a case file says of the disturbances of the thermal network, where its temperatures are from there."""

from __future__ import annotations

from tedm_cli.contracts.spec import NAMES, Dataset

NETWORK = "network"  # there where temperatures are those of the thermal network


class DisturbanceDatasets:
    """Shares of the noise by disturbance, and what each may be."""

    DISTURBANCE_NAME = Dataset(
        "/disturbance/name",
        ("disturbance",),
        "str",
        "1",
        "disturbances of the thermal network, then areas that its map leaves out, with a spectrum of their own",
        "",
        True,
        NAMES,
        group=NETWORK,
    )
    DISTURBANCE_SHARE = Dataset(
        "/disturbance/share",
        ("output", "disturbance"),
        "float",
        "1",
        "share of the PSD at /contribution/frequency; negative where it cancels others that it is correlated with",
        optional=True,
        group=NETWORK,
    )
    DISTURBANCE_BAND_SHARE = Dataset(
        "/disturbance/band_share",
        ("output", "disturbance"),
        "float",
        "1",
        "share of the power in /contribution/band",
        optional=True,
        group=NETWORK,
    )
    DISTURBANCE_ASD = Dataset(
        "/disturbance/asd",
        ("output", "disturbance", "frequency"),
        "float",
        None,
        "amplitude spectral density of the output, in its unit per sqrt(Hz), by the disturbance alone",
        optional=True,
        group=NETWORK,
    )
    DISTURBANCE_LEVEL_FACTOR = Dataset(
        "/disturbance/level_factor",
        ("verdict", "disturbance"),
        "float",
        "1",
        "factor on the level of the disturbance, others unchanged, that just meets the requirement; NaN: none does; "
        "infinite: it has no part",
        optional=True,
        open_ended=True,
        group=NETWORK,
    )
