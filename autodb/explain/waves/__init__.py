"""Explain a milled cut: the forces of its teeth over time."""
