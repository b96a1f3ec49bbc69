"""Inputs of the codecs: random means, positions in Morton order, skewed symbols."""

import numpy as np
import torch

from mobilegs.mgs.positions import morton_codes


def random_means(count: int, seed: int = 0) -> torch.Tensor:
    """Return means `[count, 3]` of a normal distribution around (1, -2, 30)."""
    center = torch.tensor([1.0, -2.0, 30.0])
    return 4 * torch.randn(count, 3, generator=torch.Generator().manual_seed(seed)) + center


def in_morton_order(stored: torch.Tensor) -> torch.Tensor:
    return stored[torch.from_numpy(np.argsort(morton_codes(stored), kind="stable"))]


def skewed_symbols(count: int, alphabet: int, seed: int = 0) -> np.ndarray:
    """Return symbols of which small ones are frequent."""
    draws = np.abs(np.random.default_rng(seed).normal(0, alphabet / 5, count))
    return np.minimum(draws, alphabet - 1).astype(np.uint16)
