"""A capture rendered from an existing scene, for training without the original photos."""
