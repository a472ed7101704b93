"""Packets of the Pioneer's protocol, and what is in them."""
