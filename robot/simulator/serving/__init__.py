"""Where clients reach the simulated robot, and its clock."""
