"""How thermal nodes lie on the finite elements."""

from __future__ import annotations

from pydantic import Field, model_validator

from tedm_cli.config.base import FileName, Strict


class MapTable(Strict):
    """Which elements each thermal node is."""

    elements: FileName | None = Field(default=None, description="A CSV `tmm_node,element_id`.")
    areas: bool = Field(default=False, description="Whether the thermal areas of the model are the nodes.")

    def file_names(self) -> list[str]:
        """The files that it names."""
        return [] if self.elements is None else [self.elements]

    @model_validator(mode="after")
    def _one_association(self) -> MapTable:
        if (self.elements is None) != self.areas:
            raise ValueError("needs either elements or areas = true")
        return self
