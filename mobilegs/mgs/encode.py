"""Build a quantised scene from a trained student's means, quantisers and decoders."""

from collections.abc import Mapping

import torch
from jaxtyping import Float
from torch import Tensor, nn

from mobilegs.mgs.positions import PositionGrid
from mobilegs.mgs.quantized_scene import QuantizedScene
from mobilegs.render.view_network import ViewNetwork
from mobilegs.representation.appearance import AppearanceDecoder, ColorDecoder, LatentDecoder
from mobilegs.representation.codebooks import Attribute, SubVectorCodebooks
from mobilegs.representation.float16 import SIGNIFICAND_BITS, to_float16
from mobilegs.representation.lobes import LobeDecoder
from mobilegs.representation.rotations import RotationQuantizer
from mobilegs.representation.uniform_quantizer import UniformQuantizer

Quantizer = SubVectorCodebooks | UniformQuantizer | RotationQuantizer


def encode_scene(
    means: Float[Tensor, "n 3"],
    quantizers: Mapping[Attribute, Quantizer],
    grid: PositionGrid,
    decoder: ColorDecoder,
    lobe_decoder: LobeDecoder | None = None,
    network: ViewNetwork | None = None,
) -> QuantizedScene:
    """Return the codes and weights of a trained student, rounded as a file stores them.

    `quantizers` are codebooks for every attribute, or uniform quantisers for every attribute:
    `scale` (log-scales), `rotation` (quaternions), `appearance` (static and view latents),
    `opacity` (base logits) and `lobes` (latents of the lobe decoder). The fields that are not
    trained (`blend`, `weighting`, `background`, `near`, `views`, `meta`) have their defaults: set
    them with `dataclasses.replace`. Raises InputError if a part is missing, out of range or not
    finite.
    """
    books: dict[Attribute, Tensor] = {}
    step_sizes: dict[Attribute, float] = {}
    for name, quantizer in quantizers.items():
        if isinstance(quantizer, SubVectorCodebooks):
            books[name] = _stored(quantizer.centers)
        else:
            step_sizes[name] = float(quantizer.step_size.detach())
    dtype = torch.int32 if step_sizes else torch.int16
    scene = QuantizedScene(
        positions=grid.store(means).cpu(),
        grid=grid,
        indices={name: part.indices.to("cpu", dtype) for name, part in quantizers.items()},
        codebooks=books,
        step_sizes=step_sizes,
        decoder=_weights(decoder),
        lobe_shape=None if lobe_decoder is None else lobe_decoder.shape,
        lobe_decoder={} if lobe_decoder is None else _weights(lobe_decoder),
        network=None if network is None else _weights(network),
    )
    scene.check()
    return scene


def _weights(module: nn.Module) -> dict[str, Tensor]:
    bits = SIGNIFICAND_BITS
    if isinstance(module, AppearanceDecoder | LatentDecoder | LobeDecoder):
        bits = module.significand_bits
    return {
        name: _stored(value, bits if value.ndim == 2 else SIGNIFICAND_BITS)
        for name, value in module.named_parameters()
    }


def _stored(values: Tensor, significand_bits: int = SIGNIFICAND_BITS) -> Tensor:
    return to_float16(values.detach(), significand_bits).cpu()
