"""Stages on the balance of the field at rest."""
