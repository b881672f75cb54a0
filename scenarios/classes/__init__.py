"""A class of sealed robots: drawn from a secret, served to students, graded by the truth that nobody was told."""
