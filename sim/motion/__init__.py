"""MuJoCo moves the arm in time: a stream of commands in, readings at their times out."""
