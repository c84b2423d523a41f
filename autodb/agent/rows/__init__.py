"""Rows of the database as objects, and objects as rows."""
