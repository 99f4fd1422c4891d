"""The only room that imports pyNastran: decks and results in and out, converted to SI and the basic frame."""

from tedm_cli.nastran.library import restore_names

restore_names()
