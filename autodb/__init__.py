"""Every CNC machine keeps its own machining database."""

__version__ = "0.1.0"
