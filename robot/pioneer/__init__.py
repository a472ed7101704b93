"""The Pioneer's serial line: packets, what they say, and the driver."""
