"""The bench: check-layout, build-optics, explain. Calls the room `optics`."""
