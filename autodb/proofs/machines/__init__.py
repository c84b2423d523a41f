"""Virtual axes, lathes and mills with physics of their own; they share no code with the estimators."""
