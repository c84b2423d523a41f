"""Proof: whatever stamps a logger writes, an answer is right or there is none."""
