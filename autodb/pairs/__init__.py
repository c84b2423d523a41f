"""What is believed of a work-tool pair: learnt from sensed forces, used to predict any operation."""
