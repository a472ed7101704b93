"""Visibility: how much views see of faces and ground, and along which lines of sight."""
