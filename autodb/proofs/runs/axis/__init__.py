"""Proofs on feed axes."""
