"""The adjoint: what every temperature does to an output. Calls the rooms `adjoint` and `fem`."""
