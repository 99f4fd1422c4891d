"""Drag-free dynamics: spacecraft and two test masses in closed loop, linear and exact. Pure: arrays in and out."""
