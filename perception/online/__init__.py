"""Views one at a time: what is known after each of them."""
