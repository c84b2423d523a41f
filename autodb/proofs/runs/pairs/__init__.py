"""Proofs on work-tool pairs."""
