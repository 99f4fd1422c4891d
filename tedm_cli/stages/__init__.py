"""One file per subcommand: read, call the pure rooms, write. Wings do not import each other; `common` is for all."""
