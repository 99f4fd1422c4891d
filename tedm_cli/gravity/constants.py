"""Physical constants of the self-gravity model."""

from __future__ import annotations

G_CODATA_2018 = 6.67430e-11
"""Newtonian constant of gravitation [m³ kg⁻¹ s⁻²], CODATA 2018 (standard uncertainty 1.5e-15)."""
