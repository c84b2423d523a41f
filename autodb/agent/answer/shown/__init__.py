"""What pages show of recordings and axes: at a glance, one by one, and over the weeks."""
