"""Milled cuts with hidden effects."""
