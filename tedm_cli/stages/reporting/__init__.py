"""What people read: plot, report, show, check, and the rules of Make. Calls `results`, `figures` and `report`."""
