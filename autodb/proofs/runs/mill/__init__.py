"""Proofs on mills, networks and dynamometers."""
