"""Moves of an axis as recorded: passes, motion, filtering."""
