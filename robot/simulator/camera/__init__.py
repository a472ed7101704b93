"""The simulated camera in real time."""
