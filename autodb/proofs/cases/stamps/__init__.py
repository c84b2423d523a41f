"""Recordings of one known axis, with every kind of time stamps that loggers write."""
