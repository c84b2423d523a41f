"""Predictions beside the cuts that were then made: linked, scored, and the next widths."""
