"""Results as lines of text and as plain dictionaries, for the terminal and for programs."""
