"""The page of a trade in HTML, PDF and Markdown, with its figure."""

from __future__ import annotations

from collections.abc import Sequence
from os.path import relpath
from pathlib import Path

from tedm_cli.chain.graph import REPORT
from tedm_cli.contracts import TRADE
from tedm_cli.files.provenance import input_files
from tedm_cli.files.store import cannot_write, open_checked, replacing
from tedm_cli.report.document import Document, Figure
from tedm_cli.report.provenance import ReportFile
from tedm_cli.report.trade import trade_document
from tedm_cli.results.trade import Trade, read_trade

FIGURES, FIGURE = "figures", "parallel.svg"
_CAPTION = (
    "Variants by criteria, parallel coordinates: an axis for each criterion with a scale of its own, a line for each"
    " variant. Higher is better on every axis."
)


def write_page(path: Path) -> list[Path]:
    """Write the page of a trade beside its file trade.h5 (`path`), in all formats; the files, the figure last.

    Raises
    ------
    InputError : the file is no trade, or the page cannot be written.
    """
    from tedm_cli.figures.drawing.style import svg

    folder = path.parent
    with open_checked(path, TRADE) as file:
        trade = read_trade(file)
        (source,) = input_files([path])
        figures = []
        if trade.front:
            from tedm_cli.figures.parallel import parallel_figure

            drawn = svg(parallel_figure(trade), _CAPTION, [f"{path.name} {source.sha256}"])
            figures.append(Figure("parallel", _CAPTION, drawn.decode(), FIGURE))
        document = trade_document(trade, figures, [ReportFile(file, source.sha256)], _reports(trade, folder))
    try:
        written = [(folder / f"trade.{form}", data) for form, data in _rendered(document)]
    except OSError as exc:  # what the PDF is set from lies on a disk for a moment
        raise cannot_write(folder / "trade.pdf", exc) from exc
    written += [(folder / FIGURES / figure.file, figure.svg.encode()) for figure in figures]
    for target, data in written:
        with replacing(target) as temporary:
            temporary.write_bytes(data)
    return [target for target, _ in written]


def _rendered(document: Document) -> Sequence[tuple[str, bytes]]:
    from tedm_cli.figures.drawing.fonts import font_folder
    from tedm_cli.report.html import to_html
    from tedm_cli.report.markdown import to_markdown
    from tedm_cli.report.pdf import to_pdf

    return (
        ("html", to_html(document).encode()),
        ("pdf", to_pdf(document, font_folder())),
        ("md", to_markdown(document, FIGURES).encode()),
    )


def _reports(trade: Trade, folder: Path) -> list[str]:
    """Of each variant the report that `tedm run` has made in its build folder, as seen from the page; "" without."""
    paths = [folder / variant.build / REPORT for variant in trade.variants]
    return [Path(relpath(path, folder)).as_posix() if path.is_file() else "" for path in paths]
