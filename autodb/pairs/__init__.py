"""The posterior of a work-tool pair: learnt from sensed forces, to predict any operation."""
