"""The line to the robot, and the process that owns it."""
