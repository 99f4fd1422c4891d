"""Temperature noise and series: run-case, run-series. Calls the room `noise`."""
