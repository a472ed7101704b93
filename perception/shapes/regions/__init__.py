"""Code that meshes and clouds share: flat regions, up, sight lines; regions into a scene."""
