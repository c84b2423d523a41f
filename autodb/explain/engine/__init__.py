"""The search for effects in white rows: candidates, evidence, confidence."""
