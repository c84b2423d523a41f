"""From a job to its forces: cuts one by one, along a path, as waves, against limits."""
