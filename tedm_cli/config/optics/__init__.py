"""The optical layout file: read strictly, checked across its tables and against the model."""
