"""Verdicts and other lists of a Dataset as a pandas table."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tedm_cli.stages.common import known_name

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr


def table(results: xr.Dataset, dimension: str = "verdict") -> pd.DataFrame:
    """Everything that `results` say of the places along one dimension, as a table with a line for each.

    Parameters
    ----------
    results : of this library.
    dimension : `verdict` (of cases, series and simulations), `dc_verdict` (of the field at rest in `sensitivity`),
        `area`, `output`, `requirement`, or any other.

    Returns
    -------
    A DataFrame. Its columns are the variables and coordinates of that dimension alone, without the name of the
    dimension before theirs: `ratio` of `verdict_ratio`. Units are those of the variables; columns `passed` are true
    or false.

    Raises
    ------
    UsageError : the results have no such dimension.

    Examples
    --------
    >>> verdicts = tedm.table(project.run_case(3))  # doctest: +SKIP
    >>> verdicts[~verdicts.passed].sort_values("ratio")  # doctest: +SKIP
    """
    known_name("dimension", dimension, [str(d) for d in results.sizes])
    along = [name for name, v in results.variables.items() if v.dims == (dimension,) and name != dimension]
    frame = results[along].reset_coords().to_dataframe()
    if f"{dimension}_passed" in frame:
        frame[f"{dimension}_passed"] = frame[f"{dimension}_passed"].astype(bool)
    frame = frame[sorted(along, key=lambda name: name not in results.coords)]  # words first
    return frame.rename(columns={name: str(name).removeprefix(f"{dimension}_") for name in along})
