"""Edits of finished scenes: Gaussians removed, notes set, always into a new file."""
