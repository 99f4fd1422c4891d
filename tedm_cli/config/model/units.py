"""Units of the decks in the configuration of a model: a system by name, or its units one by one."""

from __future__ import annotations

import difflib
from typing import Literal

from pydantic import Field, field_validator, model_validator

from tedm_cli.config.base import Duration, Length, Mass, Strict
from tedm_cli.deck_units import SYSTEMS, DeckUnits

_KEYS = ("length_m", "mass_kg", "time_s")


class UnitsTable(Strict):
    """Units of the decks and their results; SI unless said."""

    units: str | None = Field(
        default=None,
        description='A system of units by name, of `bdf`, `deck` and `op2` alike: "m-kg-s" (where left out), "mm-t-s", '
        '"mm-kg-s" or "in-lbf-s".',
    )
    length_m: Length | None = Field(
        default=None,
        description="The unit of length of the decks, in metres. With `mass_kg` and `time_s`, in place of `units`.",
    )
    mass_kg: Mass | None = Field(default=None, description="The unit of mass of the decks, in kilograms.")
    time_s: Duration | None = Field(default=None, description="The unit of time of the decks, in seconds.")
    temperature: Literal["K", "degC", "degF"] = Field(
        default="K", description="Scale of TEMP, TEMPD and TREF, per degree of which expansions are."
    )

    @field_validator("units")
    @classmethod
    def _known(cls, value: str | None) -> str | None:
        if value is not None and value not in SYSTEMS:
            near = difflib.get_close_matches(value.lower(), list(SYSTEMS), n=1, cutoff=0.5)
            raise ValueError(
                f"no system of units is called {value!r:.60}"
                + (f"; did you mean {near[0]}?" if near else "")
                + f" (known: {', '.join(SYSTEMS)}; or give length_m, mass_kg and time_s)"
            )
        return value

    @model_validator(mode="after")
    def _said_once(self) -> UnitsTable:
        given = [key for key in _KEYS if getattr(self, key) is not None]
        if given and self.units is not None:
            raise ValueError(f"units and {', '.join(given)} both say what the units are: give one of them")
        if given and len(given) < len(_KEYS):
            missing = [key for key in _KEYS if key not in given]
            raise ValueError(f"{', '.join(given)} without {', '.join(missing)}: a system has all three")
        return self

    def unit_notes(self) -> list[str]:
        """A remark where the scale of temperature is likely to have been forgotten, which no number of a deck tells."""
        if self.units != "in-lbf-s" or "temperature" in self.model_fields_set:
            return []
        return [
            "temperatures and expansions are taken in kelvin: is the deck in degrees Fahrenheit? then set temperature ="
            ' "degF", else "K"'
        ]

    def deck_units(self) -> DeckUnits:
        """The units as the readers of decks and results take them."""
        if self.length_m is not None and self.mass_kg is not None and self.time_s is not None:
            return DeckUnits(self.length_m, self.mass_kg, self.time_s, self.temperature)
        return DeckUnits(*SYSTEMS[self.units or "m-kg-s"], self.temperature)
