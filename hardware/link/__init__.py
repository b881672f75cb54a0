"""The serial link to the servo board, from bytes to moves."""
