"""What changes from cut to cut of a pair that nobody recorded: an edge, a calibration."""
