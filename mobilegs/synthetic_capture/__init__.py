"""Photographs of a scene that is there already, where there is no capture to learn from."""
