"""The Pioneer's serial protocol: packets, their contents, and the driver."""
