"""build-loads: motions of supports, gravity and moisture that are released, and natural frequencies."""
