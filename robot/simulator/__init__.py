"""The simulated robot: firmware, motion, world, camera, and the servers that offer them."""
