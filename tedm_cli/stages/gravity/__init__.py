"""Self-gravity: build-sensitivity, self-gravity, audit-mesh, accuracy. Calls the room `gravity`."""
