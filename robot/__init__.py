"""Views from a robot: driver, camera head and tours; a simulated robot in rendered worlds."""
