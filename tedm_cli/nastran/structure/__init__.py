"""A deck as the structure that `fem` solves, elements, sections, constraints and loads; the rest is refused."""
