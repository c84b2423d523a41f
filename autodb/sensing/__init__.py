"""Estimators: recording in, force ± standard deviation per component out, or *not sensed*."""
