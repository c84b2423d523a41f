"""Least squares with honest uncertainty: rank, bounds, priors, covariances, held-out scores."""
