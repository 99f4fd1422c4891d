"""The report: what `results` says, arranged as one document, and that as HTML, PDF and Markdown."""
