"""Mobile-GS: 3D Gaussian splatting without sorting, in a file of a few megabytes."""

__version__ = "0.1.0"
