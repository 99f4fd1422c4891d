"""explain: what a name of the report stands for, and what it is made of. One file for each sort of name."""
