"""What we believe: kinematics, camera, servo and effect terms, nominal values."""
