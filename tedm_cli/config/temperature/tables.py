"""The temperature model of a cases file, with the tables of spectra it names."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from tedm_cli.config.cases import CasesConfig
from tedm_cli.config.project import Project
from tedm_cli.config.temperature.spectrum import SpectrumColumns
from tedm_cli.errors import InputError
from tedm_cli.noise.areas import AreaTable
from tedm_cli.noise.temperature import TemperatureModel
from tedm_cli.quantities import FREQUENCY, Quantity
from tedm_cli.tables.wide_table import open_wide

_MOST_ROWS = 100_000


def table_paths(project: Project, config: CasesConfig) -> list[Path]:
    """Files with spectra; their names are relative to the cases file."""
    return [project.cases.parent / name for name in config.temperature.table_names()]


def temperature_model(
    project: Project, config: CasesConfig, areas: AreaTable, tables: Mapping[str, SpectrumColumns] | None = None
) -> TemperatureModel:
    """The model of the thermal areas; raises what reading a table and `TemperatureTable.model` raise.

    `tables`, by the names that the configuration has for them, are spectra that no file holds.
    """
    return config.temperature.model(areas, spectrum_tables(project, config, tables), where=str(project.cases))


def spectrum_tables(
    project: Project, config: CasesConfig, tables: Mapping[str, SpectrumColumns] | None = None
) -> dict[str, SpectrumColumns]:
    """What the tables of spectra hold, by the names in the configuration; `tables`: as `temperature_model`."""
    quantities = config.temperature.table_quantities()
    held = tables or {}
    return {
        name: held[name] if name in held else _read(path, quantity)
        for (name, quantity), path in zip(quantities.items(), table_paths(project, config), strict=True)
    }


def _read(path: Path, quantity: Quantity) -> SpectrumColumns:
    with open_wide(path, "frequency_hz", FREQUENCY, quantity) as table:
        blocks, rows = [], 0
        for block in table.blocks():
            blocks.append(block)
            rows += len(block.key)
            if rows > _MOST_ROWS:
                fact = f"holds more than {_MOST_ROWS:,} frequencies"
                raise InputError(fact, where=str(path), hint="a spectrum is straight between its points: thin it out")
        if not blocks:
            raise InputError("holds the names of its columns and no row", where=str(path))
        frequency, asd = (np.concatenate(parts) for parts in ([b.key for b in blocks], [b.values for b in blocks]))
        return SpectrumColumns(str(path), table.columns, frequency, asd)
