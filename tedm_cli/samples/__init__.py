"""The shipped samples: what the project of each is made of. The files lie beside this one, or in the repository."""
