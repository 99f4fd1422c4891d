"""Configuration of one correlation case: blocks, or a partition of groups, or a matrix; coefficients and delays."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, model_validator

from tedm_cli.config.base import IDENTIFIER, Bounded, Coefficient, FileName, Form, Strict
from tedm_cli.config.correlation.file import read_matrix
from tedm_cli.noise.correlation import CorrelationCase, Role
from tedm_cli.noise.selection import BlockSelector
from tedm_cli.quantities import DELAY

Names = Annotated[list[Annotated[str, Field(min_length=1)]], Field(min_length=1)]
Partition = Literal["all", "none", "group", "shield", "side", "mirror"]


def _identifier(value: Any) -> Any:
    """Case ids may be written as numbers."""
    return str(value) if isinstance(value, int) and not isinstance(value, bool) else value


CaseId = Annotated[str, BeforeValidator(_identifier), Field(pattern=IDENTIFIER), Form("text or whole number")]


class SelectorTable(Strict):
    """Some areas: each key given narrows the choice, any of its values will do."""

    groups: Names | None = Field(default=None, description="Areas of these groups.")
    shield: Annotated[list[Literal["inside", "outside"]], Field(min_length=1)] | None = Field(
        default=None, description="Areas on these sides of the thermal shield."
    )
    side: Annotated[list[Literal["+y", "-y", "mid"]], Field(min_length=1)] | None = Field(
        default=None, description="Areas on these sides of the symmetry plane."
    )
    areas: Names | None = Field(default=None, description='Areas whose names match these patterns; `["*"]` is all.')

    @model_validator(mode="after")
    def _selects(self) -> Self:
        if self.groups is None and self.shield is None and self.side is None and self.areas is None:
            raise ValueError('selects nothing: give groups, shield, side or areas (areas = ["*"] for all)')
        return self

    def chosen(self) -> BlockSelector:
        """The areas as the correlation model takes them."""
        return BlockSelector(
            tuple(self.groups or ()), tuple(self.shield or ()), tuple(self.side or ()), tuple(self.areas or ())
        )


class BlockTable(SelectorTable):
    """Areas of one block, or of several that `partition` makes of them.

    Each key that selects areas narrows the choice, any of its values will do.
    """

    each_alone: bool = Field(
        default=False, description='Whether every area is a block of its own; short for `partition = "none"`.'
    )
    partition: Partition = Field(
        default="all",
        description='How the areas are divided into blocks: not at all ("all"), each alone ("none"), by '
        "group, by shield, by side, or each with its mirror image.",
    )
    mirror_names: Annotated[list[Annotated[str, Field(min_length=1)]], Field(min_length=2, max_length=2)] | None = (
        Field(
            default=None,
            description='Parts of the names that tell an area from its mirror image, as `["_PLUS_Y", "_MINUS_Y"]`. '
            "Left out, images are found by centroids.",
        )
    )
    rho: Coefficient | None = Field(
        default=None, description="Correlation coefficient of any two areas of the block. Else that of the case."
    )
    across_kinds: bool = Field(
        default=False,
        description="Whether a block holds mean temperatures and gradients together. Else it is a block of each.",
    )

    @model_validator(mode="after")
    def _divides_once(self) -> Self:
        if self.each_alone and "partition" in self.model_fields_set:
            raise ValueError("each_alone is partition = 'none'; give one of the two")
        if self.mirror_names is not None and self.partition != "mirror":
            raise ValueError("mirror_names needs partition = 'mirror'")
        if self.rho is not None and (self.each_alone or self.partition == "none"):
            raise ValueError("rho is between the areas of a block, but each area is alone")
        if self.across_kinds:
            _require_joinable("none" if self.each_alone else self.partition)
        return self

    def selector(self, rho: float | None) -> BlockSelector:
        """The block as the correlation model takes it; `rho`, of the case, where the block has none."""
        own = self.rho if self.rho is not None else rho
        return replace(
            self.chosen(),
            partition="none" if self.each_alone else self.partition,
            mirror_names=tuple(self.mirror_names or ()),
            rho=1.0 if own is None else own,
            across_kinds=self.across_kinds,
        )


def _require_joinable(partition: Partition) -> None:
    """Raise where blocks of a partition cannot hold means and gradients together."""
    if partition == "none":
        raise ValueError("across_kinds joins areas in a block, but each area is alone")
    if partition == "mirror":
        raise ValueError("across_kinds cannot be used with mirror, which pairs areas of the same kind")


class DelayTable(SelectorTable):
    """Areas that follow later. Each key that selects areas narrows the choice, any of its values will do."""

    delay_s: Annotated[float, Bounded(DELAY)] = Field(
        description="How much later than areas without a delay these follow, as coherent as before."
    )


class CaseTable(Strict):
    """One correlation case: `blocks`, a `partition` of the areas, a `matrix`, or `thermal`, the thermal network."""

    id: CaseId = Field(description="Id of the case, by which commands and files name it.")
    title: str = Field(min_length=1, description="Title of the case.")
    role: Role = Field(
        default="possible",
        description="How to read the case: likely in flight, possible, or diagnostic, which isolates a part "
        "and is not physical. No number depends on it.",
    )
    reason: str = Field(default="", description="Why the case is there, for prints and the report.")
    blocks: Annotated[list[BlockTable], Field(min_length=1)] | None = Field(
        default=None,
        description="Blocks of areas that move together. Blocks are uncorrelated with each other, and areas "
        "in no block are silent. One of `blocks`, `partition`, `matrix` and `thermal` is needed.",
    )
    partition: Partition | None = Field(
        default=None, description="One block of `groups`, or of all areas, divided as in a block."
    )
    groups: Names | None = Field(default=None, description="Groups of areas that `partition` divides. Else all areas.")
    matrix: FileName | None = Field(
        default=None,
        description="The correlation itself: a CSV whose header is `area` and names, or an NPZ with arrays "
        "`area` and `R`.",
    )
    thermal: Literal[True] | None = Field(
        default=None,
        description="Whether temperatures and their correlation are those of the thermal network (thermal.h5) in place "
        "of `[temperature]` and blocks. Areas that its map leaves out keep their spectra, uncorrelated.",
    )
    rho: Coefficient | None = Field(
        default=None, description="Correlation coefficient inside blocks that have none of their own; 1 where left out."
    )
    across_kinds: bool = Field(default=False, description="As in a block, beside `partition`.")
    delays: list[DelayTable] = Field(default_factory=list, description="Areas that follow later.")

    @model_validator(mode="after")
    def _one_correlation(self) -> Self:
        given = [key for key in ("blocks", "partition", "matrix", "thermal") if getattr(self, key) is not None]
        if len(given) != 1:
            found = " and ".join(given) if given else "none"
            raise ValueError(f"give one of blocks, partition, matrix and thermal (found {found})")
        if self.thermal and (idle := [k for k in ("rho", "across_kinds", "delays") if k in self.model_fields_set]):
            raise ValueError(f"thermal has correlations and delays of its own: leave {' and '.join(idle)} out")
        if self.groups is not None and self.partition is None:
            raise ValueError("groups needs a partition")
        if self.rho is not None and (self.matrix is not None or self.partition == "none"):
            raise ValueError(f"rho cannot be used with {given[0]}{' none' if self.partition else ''}")
        if self.across_kinds:
            if self.partition is None:
                raise ValueError("across_kinds needs a partition; blocks have their own, and a matrix says it all")
            _require_joinable(self.partition)
        return self

    def correlation_case(self, where: str) -> CorrelationCase:
        """The case as the correlation model takes it, its matrix read; raises `InputError` for the file."""
        selectors = tuple(b.selector(self.rho) for b in self.blocks or ())
        if self.partition is not None:
            rho = 1.0 if self.rho is None else self.rho
            groups, areas = tuple(self.groups or ()), () if self.groups else ("*",)
            selectors = (
                BlockSelector(
                    groups=groups, areas=areas, partition=self.partition, rho=rho, across_kinds=self.across_kinds
                ),
            )
        return CorrelationCase(
            self.id,
            self.title,
            selectors,
            where,
            None if self.matrix is None else read_matrix(Path(self.matrix)),
            tuple((d.chosen(), d.delay_s) for d in self.delays),
            self.role,
            self.reason,
            bool(self.thermal),
        )
