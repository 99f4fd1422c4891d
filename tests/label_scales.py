"""Which datasets of a file are no results: its dimensions, and the copies of labels that they bear."""

from __future__ import annotations

import h5py

from tedm_cli.contracts import KINDS


def is_scale_alone(item: h5py.Dataset) -> bool:
    """Whether a dataset is a dimension scale and nothing else; `/frequency`, which is one, is a result too."""
    schema = item.file.attrs["schema"]
    contract = KINDS[str(schema).removeprefix("tedm.")].datasets
    return item.name not in contract and "CLASS" in item.attrs
