"""From imported recordings to sensed forces: calibrations, drive models, networks, dynamometers."""
