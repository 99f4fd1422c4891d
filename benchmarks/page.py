"""Tables and figures of docs/reference/scale.md from stored results: `python -m benchmarks.page [FOLDER]`.

The results of FOLDER, if one is named, are stored first (benchmarks/results/). A table stands between the lines
`<!-- benchmark NAME -->` and `<!-- end -->`, with the commit and the day below it. Sets older than the code are told.
"""

from __future__ import annotations

import re
import shutil
import sys
from pathlib import Path

from benchmarks.plots import FIGURES
from benchmarks.process import ROOT
from benchmarks.record import STORED, Record, stored
from benchmarks.tables import TABLES

PAGE = ROOT / "docs" / "reference" / "scale.md"
IMAGES = ROOT / "docs" / "images"
_PLACE = re.compile(r"<!-- benchmark (?P<name>[a-z0-9-]+) -->\n.*?<!-- end -->", re.DOTALL)


def filled(text: str, records: dict[str, Record]) -> str:
    """The page with the tables of these results in their places.

    A table without results says so. LookupError for a table without a place, or the other way round.
    """
    tables = {table.name: table for table in TABLES}
    if missing := sorted(set(tables) - set(_PLACE.findall(text))):
        raise LookupError(f"the page has no place for {', '.join(missing)}")

    def table(place: re.Match[str]) -> str:
        found = tables[place["name"]]
        of = records.get(found.of)
        text = found.markdown(of) if of else f"*Not measured: `python -m benchmarks {found.of}`.*"
        return f"<!-- benchmark {found.name} -->\n{text}\n<!-- end -->"

    return _PLACE.sub(table, text)


def figures(records: dict[str, Record]) -> dict[str, bytes]:
    """Every figure of the page by its file name."""
    return {name: draw(records[of]) for name, (of, draw) in FIGURES.items() if of in records}


def main() -> None:
    """Store, fill, draw, and tell what is older than the code."""
    for folder in sys.argv[1:]:
        STORED.mkdir(exist_ok=True)
        for path in sorted(Path(folder).glob("*.json")):
            shutil.copyfile(path, STORED / path.name)
    records = stored()
    PAGE.write_text(filled(PAGE.read_text(encoding="utf-8"), records), encoding="utf-8")
    for name, content in figures(records).items():
        (IMAGES / name).write_bytes(content)
    for name, record in records.items():
        commits = record.about.commits_since()
        age = "its commit is not here" if commits is None else f"{commits} commits of the code since"
        print(f"{name:10} {record.about.day}  {record.about.commit:9} {age}")


if __name__ == "__main__":
    main()
