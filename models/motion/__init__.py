"""What we believe of an arm in motion: one servo's loop in time, and the loads that it bears."""
