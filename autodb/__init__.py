"""Every CNC machine keeps its own machining database."""

__version__ = "0.2.0"
