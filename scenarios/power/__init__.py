"""Power before measuring: how large a fault must be to be found by a plan, and what it is taken for when smaller."""
