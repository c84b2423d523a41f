"""Virtual axes, lathes and mills with physics of their own: no code shared with the estimators."""
