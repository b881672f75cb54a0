"""What a log of a moving arm says of its servos: identification in time, joint by joint."""
