"""Errors a user can act on. Each class owns its exit code; the command line prints `where: fact` and `hint: fix`."""

from __future__ import annotations


class TedmError(Exception):
    """Base of all expected failures.

    Parameters
    ----------
    fact : what is wrong, in one line, with the numbers that show it.
    where : file, and place inside it, that the fact is about (may be empty).
    hint : what the user can do about it (may be empty).

    As text it is `where: fact`, and a line `hint: fix`: a traceback of Python shows no more of it than that.
    """

    exit_code = 1

    def __init__(self, fact: str, *, where: str = "", hint: str = "") -> None:
        fact = printable(fact)
        super().__init__(f"{where}: {fact}" if where else fact)
        self.fact = fact
        self.where = where
        self.hint = hint

    def __str__(self) -> str:
        return f"{self.placed}\nhint: {self.hint}" if self.hint else self.placed

    @property
    def placed(self) -> str:
        """`where: fact`, to be quoted by another error."""
        return super().__str__()


class UsageError(TedmError):
    """The command line asks for something that does not exist (a case, an output, a file kind)."""

    exit_code = 2


class ConfigError(TedmError):
    """A configuration file is malformed; `problems` lists every one of them as (dotted path, fact)."""

    exit_code = 3

    def __init__(self, problems: list[tuple[str, str]], *, where: str, hint: str = "") -> None:
        lines = [f"{path}: {fact}" if path else fact for path, fact in problems]
        super().__init__("\n".join(lines), where=where, hint=hint)
        self.problems = problems


class InputError(TedmError):
    """An input file, or a file between two stages, breaks its contract (missing, truncated, stale, wrong version)."""

    exit_code = 4


class MemoryShortError(InputError):
    """A model needs more memory than the machine has left."""


class PhysicsError(TedmError):
    """A physical check failed: a residual, a rank, a singular structure, a model that reaches into a test mass."""

    exit_code = 5


def printable(text: str) -> str:
    """What a message quotes of a damaged file must not move the cursor or ring the bell."""
    return "".join(c if c.isprintable() or c == "\n" else "?" for c in text)
