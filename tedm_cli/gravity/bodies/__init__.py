"""Shapes that a test mass may have: cuboid, sphere, cylinder, polyhedron, and what is put together of them."""
