"""Which matrices of each kind of file are exported, and in which formats; a new one is a module or an entry."""
