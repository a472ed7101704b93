"""Views from a robot, simulated so far: worlds, renderer, tours."""
