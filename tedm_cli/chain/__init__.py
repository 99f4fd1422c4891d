"""The chain of stages as a graph: what each step makes and of what, what is stale and why, what can run next. Pure."""
