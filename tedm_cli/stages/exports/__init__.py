"""What other programs read: matrices, cases, state spaces, meshes. Calls the room `exports`."""
