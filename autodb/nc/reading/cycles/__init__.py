"""Cycles of lathes and mills, written out as the moves that they make."""
