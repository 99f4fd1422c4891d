"""Configuration of effects of the user's own: tables of what temperatures do to outputs, beside all matrices."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from pydantic import Field

from tedm_cli.config.base import IDENTIFIER, FileName, Strict
from tedm_cli.quantities import EFFECT
from tedm_cli.tables.csv_table import Row, read_table

COLUMNS = {"output": None, "area": None, "value": EFFECT, "unit": None}


class EffectTable(Strict):
    """An effect of your own on outputs, such as a force on a test mass by the gas around it."""

    name: Annotated[str, Field(pattern=IDENTIFIER)] = Field(description="Name of the effect, in prints and results.")
    table: FileName = Field(
        description="A CSV `output,area,value,unit`: what one kelvin of a thermal area does to an output. Pairs that "
        "it does not have are 0."
    )


def read_effect(path: Path) -> list[Row]:
    """The lines of the table of an effect; `InputError` as `read_table` raises it."""
    return read_table(path, COLUMNS)
