"""Collecting views with a robot: driver, camera head, tours; a simulator with rendered worlds."""
