"""Gross errors of the set-up, looked for before anything is fitted: a joint's sign, exchanged cables, a mirror."""
