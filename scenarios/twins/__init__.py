"""What a twin is used for: a plan run through it, and commands corrected by it."""
