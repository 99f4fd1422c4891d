"""The one place that imports xarray, which is optional and takes longer to import than all the rest."""

from __future__ import annotations

from collections.abc import Mapping
from types import ModuleType
from typing import TYPE_CHECKING

from tedm_cli.errors import UsageError

if TYPE_CHECKING:
    import xarray as xr


def xarray() -> ModuleType:
    """The module; `UsageError` where it is not installed."""
    try:
        import xarray
    except ImportError:
        raise UsageError(
            "results from Python are xarray Datasets, and xarray is not installed",
            hint="install it with `pip install 'tedm[notebook]'`",
        ) from None
    return xarray


Variable = tuple[tuple[str, ...], object, dict[str, str]]  # dimensions, values, attributes


def variable(dims: tuple[str, ...], values: object, units: str, long_name: str, frame: str = "") -> Variable:
    """A variable of a Dataset; attributes that are empty are left out."""
    attrs = {"units": units, "long_name": long_name, "frame": frame}
    return dims, values, {k: v for k, v in attrs.items() if v}


def dataset(
    variables: Mapping[str, Variable], coordinates: Mapping[str, object], attributes: Mapping[str, object] | None = None
) -> xr.Dataset:
    """A Dataset of such variables."""
    made: xr.Dataset = xarray().Dataset(variables, coords=coordinates, attrs=attributes or {})
    return made
