"""What runs in the simulated robot: commands in, motion and reports out."""
