"""Print docs/reference/files.md."""

from tedm_cli.contracts import markdown

print(markdown(), end="")
