"""A bench served over HTTP: one bench, one mover at a time, a page for people, and a bench for programs."""
