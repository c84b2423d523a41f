"""Recordings over time and tables of cuts: named channels in our units, read from files."""
