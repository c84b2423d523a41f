"""Recordings that are sent: received, read apart, imported."""
