"""The report: numbers of result files, arranged for its templates. Reads arrays, computes next to nothing."""
