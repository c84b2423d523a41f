"""Proofs on concealed effects."""
