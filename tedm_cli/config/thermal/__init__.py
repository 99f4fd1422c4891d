"""The thermal model's configuration: the network, its disturbances, and how its nodes lie on the finite elements."""
