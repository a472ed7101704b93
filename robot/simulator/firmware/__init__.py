"""The firmware of the simulated robot: commands in, motion and reports out."""
