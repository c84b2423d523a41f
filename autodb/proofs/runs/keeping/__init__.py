"""Proofs on a day, on a fleet, on kills and flipped bits."""
