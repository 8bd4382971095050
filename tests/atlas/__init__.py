"""Scenes at which common methods fail, and the correct results."""
