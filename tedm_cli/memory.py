"""Memory that is left to this process, as far as the system tells."""

from __future__ import annotations

import os
import resource
from collections.abc import Iterator
from pathlib import Path

from tedm_cli.errors import UsageError

MEMORY_VARIABLE = "TEDM_MEMORY_GB"

_ROOT = Path("/")
# Limits of version 1 are this large where there is none.
_NO_LIMIT = 1 << 60


def available_bytes(root: Path = _ROOT) -> int | None:
    """Memory that this process can still take before the machine swaps or a limit ends it; None where nothing tells.

    The least of what the machine has left, what every control group of the process (of a container or a batch job) has
    left, and `ulimit -v`. The environment variable TEDM_MEMORY_GB, in 1e9 bytes, says it instead of all these.

    Parameters
    ----------
    root : where `proc` and `sys` are.

    Raises
    ------
    UsageError
        If the variable is no positive number.
    """
    said = os.environ.get(MEMORY_VARIABLE)
    if said is not None:
        return _said(said)
    return min(_found(root), default=None)


def _said(text: str) -> int:
    try:
        size = float(text)
    except ValueError:
        size = -1.0
    if not 0.0 < size < 1e9:
        fact = f"{MEMORY_VARIABLE} is {text!r}"
        raise UsageError(fact, where="environment", hint="give the memory in gigabytes, such as 16, or unset it")
    return round(1e9 * size)


def _found(root: Path) -> Iterator[int]:
    for line in _lines(root / "proc/meminfo"):
        if line.startswith("MemAvailable:"):
            yield 1024 * int(line.split()[1])
    limit = resource.getrlimit(resource.RLIMIT_AS)[0]
    pages = "".join(_lines(root / "proc/self/statm")).split()
    if limit != resource.RLIM_INFINITY and pages:
        yield limit - int(pages[0]) * resource.getpagesize()
    for line in _lines(root / "proc/self/cgroup"):
        _, controllers, path = line.rstrip("\n").split(":", 2)
        if not controllers:
            yield from _left(root / "sys/fs/cgroup", path, "memory.max", "memory.current", "inactive_file")
        elif "memory" in controllers.split(","):
            files = "memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file"
            yield from _left(root / "sys/fs/cgroup/memory", path, *files)


def _left(mount: Path, path: str, limit: str, usage: str, cache: str) -> Iterator[int]:
    """What a control group and those above it leave; cached files that nobody reads count as free."""
    group = mount / path.lstrip("/")
    while True:
        most, used = _number(group / limit), _number(group / usage)
        if most is not None and used is not None and most < _NO_LIMIT:
            words = [line.split() for line in _lines(group / "memory.stat")]
            yield most - used + sum(int(size) for name, size in words if name == cache)
        if group in (mount, group.parent):
            return
        group = group.parent


def _number(path: Path) -> int | None:
    text = "".join(_lines(path)).strip()
    return int(text) if text.isdigit() else None


def _lines(path: Path) -> list[str]:
    """Lines of a file of the system; none where it has no such file."""
    try:
        return path.read_text(encoding="ascii", errors="replace").splitlines()
    except OSError:
        return []
