"""Current ranges calibrated against known forces, and force sensed by them."""
