"""A capture: a plan carried out on a bench, kept pose by pose in a folder."""
