"""Self-gravity of a mass distribution on homogeneous cuboid test masses."""
