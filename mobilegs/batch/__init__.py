"""Makes the scenes of a whole list on one machine or on a Ray cluster."""
