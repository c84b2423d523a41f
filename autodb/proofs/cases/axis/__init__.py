"""Axes with hidden effects."""
