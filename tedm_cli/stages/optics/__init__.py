"""The bench: check-layout, build-optics. Calls the room `optics`."""
