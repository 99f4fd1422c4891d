"""The state of a verdict over all cases, and how its table tells it: one row for each output and requirement."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

from tedm_cli.gravity.requirements import DcVerdict
from tedm_cli.report.document import Cell, Row, State, row
from tedm_cli.results.cases.deciding import LIKELY, by_requirement, deciding, possible_of, without_repeats, worst_of
from tedm_cli.results.cases.noise import CaseNoise, JudgedOutput
from tedm_cli.results.dynamics.loop import ClosedLoop, LoopOutput, SimulatedCase
from tedm_cli.results.gravity.field import worst_at_rest
from tedm_cli.results.titles import at_rest_requirement, at_rest_title, by_subsystem, output_title
from tedm_cli.results.wording import capital, mhz_text, ratio_text

Titles = Callable[[str], str]
WORD: dict[State, str] = {"met": "met", "open": "at risk", "violated": "VIOLATED"}
_ORDER: tuple[State, ...] = ("violated", "open", "met")
NOT_JUDGED = "The configuration has no limits at rest ([[requirement_at_rest]]): the field at rest is not judged."


class Case(Protocol):
    """A case, by itself or in closed loop."""

    @property
    def id(self) -> str: ...
    @property
    def role(self) -> str: ...


class Output(Protocol):
    """One output of a case against one requirement."""

    @property
    def output(self) -> str: ...
    @property
    def requirement(self) -> str: ...
    @property
    def ratio(self) -> float: ...
    @property
    def binding_hz(self) -> float: ...
    @property
    def passed(self) -> bool: ...


C = TypeVar("C", bound=Case)
J = TypeVar("J", bound=Output)


@dataclass(frozen=True)
class Judgement(Generic[C, J]):
    """What is decided about one output and one requirement, from all cases that judge it."""

    pairs: tuple[tuple[C, J], ...]

    @property
    def decides(self) -> tuple[C, J]:
        """The case and output that the verdict hangs on."""
        return deciding(self.pairs)

    @property
    def likely(self) -> tuple[C, J] | None:
        """The worst of the likely cases; None where none is likely."""
        likely = [p for p in self.pairs if p[0].role == LIKELY]
        return worst_of(likely) if likely else None

    @property
    def possible(self) -> tuple[C, J]:
        """The worst of all cases that can occur."""
        return worst_of(possible_of(self.pairs))

    @property
    def state(self) -> State:
        """Violated in a likely case, or in any where none is likely; open where only another case violates it."""
        return state_of(self.pairs)

    @property
    def output(self) -> str:
        return self.pairs[0][1].output

    @property
    def requirement(self) -> str:
        return self.pairs[0][1].requirement


def state_of(pairs: Sequence[tuple[C, J]]) -> State:
    """State of a verdict by the roles of its cases."""
    case, j = deciding(pairs)
    if j.passed:
        return "met"
    return "violated" if case.role == LIKELY or not any(c.role == LIKELY for c, _ in pairs) else "open"


def noise_judgements(cases: Sequence[CaseNoise]) -> list[Judgement[CaseNoise, JudgedOutput]]:
    """Of every output and requirement on temperature noise; outputs that say the same are told once."""
    found = []
    for _, pairs in by_requirement(without_repeats(cases)):
        for output in dict.fromkeys(j.output for _, j in pairs):
            found.append(Judgement(tuple(p for p in pairs if p[1].output == output)))
    return found


def loop_judgements(loop: ClosedLoop | None) -> list[Judgement[SimulatedCase, LoopOutput]]:
    """Of every output and requirement in closed loop."""
    return [] if loop is None else [Judgement(tuple(pairs)) for pairs in loop.pairs().values()]


def worst_first(found: Sequence[Judgement[C, J]]) -> list[Judgement[C, J]]:
    """In the order in which a reader must know them."""
    return sorted(found, key=lambda x: (_ORDER.index(x.state), -x.decides[1].ratio))


def exceeding(verdicts: Sequence[DcVerdict]) -> list[DcVerdict]:
    """Quantities of the field at rest that exceed their limits."""
    return [v for v in verdicts if not v.passed]


def state_cell(state: State) -> Cell:
    """A state in a word."""
    return Cell(WORD[state], state)


def margin_text(ratio: float) -> str:
    """The factor by which the noise may grow."""
    return ratio_text(1.0 / ratio) if ratio > 0.0 else "any"


def judgement_rows(
    found: Sequence[Judgement[C, J]], titles: Titles, by_role: bool, more: Callable[[C, J], Cell] | None = None
) -> list[Row]:
    """Rows of the table of verdicts; outputs of which the same is to be said share one.

    `by_role`: likely cases and all that can occur have columns of their own. `more`: a last cell, of the case
    whose ratio is told.
    """
    alike: dict[tuple[Cell | str, ...], list[str]] = {}
    for one in found:
        last = [] if more is None else [more(*(one.likely or one.possible))]
        alike.setdefault((*_said(one, titles, by_role), *last), []).append(one.output)
    return [
        row(Cell(capital(output_title(", ".join(outputs))), label=", ".join(sorted(outputs))), *cells)
        for cells, outputs in alike.items()
    ]


def _said(found: Judgement[C, J], titles: Titles, by_role: bool) -> tuple[Cell | str, ...]:
    likely, worst = found.likely, found.possible
    case, j = likely or worst
    cells: list[Cell | str] = [
        titles(found.requirement),
        state_cell(found.state),
        Cell(ratio_text(j.ratio), "met" if j.passed else "violated"),
        margin_text(j.ratio),
        mhz_text(j.binding_hz),
        f"case {case.id}",
    ]
    if by_role:
        passed = worst[1].passed
        cells.append(Cell(f"{ratio_text(worst[1].ratio)} (case {worst[0].id})", "met" if passed else "open"))
    return tuple(cells)


def at_rest_rows(verdicts: Sequence[DcVerdict], by_role: bool) -> list[Row]:
    """Rows of the table of verdicts: the worst quantity of each requirement at rest, by test mass and difference."""
    alike: dict[tuple[Cell | str, ...], list[DcVerdict]] = {}
    for requirement, place in dict.fromkeys((v.requirement, v.place) for v in verdicts):
        own = [v for v in verdicts if (v.requirement, v.place) == (requirement, place)]
        worst = worst_at_rest(own)
        state: State = "violated" if exceeding(own) else "met"
        cells: list[Cell | str] = [
            at_rest_requirement(requirement),
            state_cell(state),
            Cell(ratio_text(worst.ratio), state),
            margin_text(worst.ratio),
            "at rest",
            f"{len(exceeding(own))} of {len(own)} exceed",
            *([""] if by_role else []),
        ]
        alike.setdefault((worst.quantity, worst.subsystem, *cells), []).append(worst)
    return [
        row(
            f"{capital(at_rest_title(v[0].quantity, *(w.place for w in v)))}, by {by_subsystem(v[0].subsystem)}",
            *cells[2:],
        )
        for cells, v in alike.items()
    ]
