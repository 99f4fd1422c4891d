"""Pages of the documentation as messages name them: by title, for a wheel brings no files of them."""

from __future__ import annotations

from enum import StrEnum


class Page(StrEnum):
    """A page, as what is printed names it; a test compares the titles with those of the pages."""

    SOLVER = 'documentation: "The embedded solver"'
    TEMPERATURES = 'documentation: "Temperatures"'
