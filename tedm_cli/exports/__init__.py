"""Which matrices of each kind of file go out, and in which formats; a new format or kind is a module or an entry."""
