"""Proofs on the calibration of lathes."""
