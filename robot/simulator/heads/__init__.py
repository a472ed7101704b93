"""The simulated camera heads, each a device on a serial line."""
