"""Rows as they are: laws that predict those left out of the fit, and how sure of them one is."""
