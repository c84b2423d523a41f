"""One machine's life: import → calibrate → identify → refresh → predict → explain → trace."""
