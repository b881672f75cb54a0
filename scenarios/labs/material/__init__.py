"""What each lab measures: recordings and pictures of simulated arms, the same on every machine."""
