"""MuJoCo moves the arm: commands in, resting poses out, with the memory of the order they came in."""
