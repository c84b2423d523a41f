"""Process forces from a dynamometer on a table that tilts and turns (P4)."""
