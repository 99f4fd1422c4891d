"""The thermal model: its network to spectra of nodes, and its nodes on the finite elements."""
