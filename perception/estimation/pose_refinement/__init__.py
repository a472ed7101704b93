"""Drifting poses, as from a robot's odometry, corrected by the straight edges in the pictures."""
