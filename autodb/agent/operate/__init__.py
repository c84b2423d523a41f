"""Keeping it running: refreshes, schedules, health, retention, access."""
