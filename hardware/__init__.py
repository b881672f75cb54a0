"""The real bench: serial protocol, firmware, webcam, capture, safety."""
