"""Poses that drift, as a robot's odometry does, put right by the straight edges in the pictures."""
