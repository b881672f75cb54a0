"""Diagnosis: what the twin gets wrong, its cause, and what naming it gains."""
