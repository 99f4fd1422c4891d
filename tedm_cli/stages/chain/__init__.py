"""The chain as a whole: new projects, what is up to date, running all stages, and telling Make of them."""
