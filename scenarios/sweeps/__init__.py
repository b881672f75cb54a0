"""Sweeps: thousands of sealed worlds over crossed factors, diagnosed on Dask, with the size that is found of each."""
