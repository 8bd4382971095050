"""Scenes at which methods fail, and what is right."""
