"""Explain the excluded cuts of many recordings together, and only what changed since."""
