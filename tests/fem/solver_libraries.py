"""The libraries that factorise: names, the packages that they need, and what they call themselves."""

from __future__ import annotations

LIBRARIES = [
    ("rslab", "rslab", "RSLAB"),
    ("mumps", "mumps", "MUMPS"),
    ("pardiso", "pypardiso", "PARDISO"),
    ("superlu", "scipy", "SuperLU"),
]
