"""The drag-free loop: build-dynamics, simulate. Calls the room `dynamics`."""
