"""Experiments that tell tied causes apart: plans, what rival models predict for them, and which separates best."""
