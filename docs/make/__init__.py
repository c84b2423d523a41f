"""Make every figure, every printed output and the command reference of the documentation."""
