"""Strict TOML to typed tables, in SI; every problem of a file is reported at once. Reads files, computes no physics."""
