"""From the trained parts of a student to a coded scene."""

from collections.abc import Mapping

import torch
from jaxtyping import Float
from torch import Tensor, nn

from mobilegs.camera import NEAR, Camera
from mobilegs.compress.appearance import AppearanceDecoder, ColorDecoder
from mobilegs.compress.codebooks import Attribute, SubVectorCodebooks
from mobilegs.compress.float16 import DIGITS, to_half
from mobilegs.compress.lobes import LobeDecoder
from mobilegs.compress.rotations import RotationCodes
from mobilegs.compress.uniform_quantizer import ScalarCodes
from mobilegs.mgs.positions import Frame
from mobilegs.mgs.quantized_scene import CodedScene, MetaValue
from mobilegs.render import Weighting
from mobilegs.render.view_network import ViewNetwork

Codes = SubVectorCodebooks | ScalarCodes | RotationCodes


def encode_scene(
    means: Float[Tensor, "n 3"],
    codebooks: Mapping[Attribute, Codes],
    *,
    frame: Frame,
    decoder: ColorDecoder,
    lobe_decoder: LobeDecoder | None = None,
    network: ViewNetwork | None = None,
    blend: str = "sortfree",
    weighting: Weighting,
    background: Float[Tensor, "3"],
    near: float = NEAR,
    views: list[Camera] | None = None,
    meta: dict[str, MetaValue] | None = None,
) -> CodedScene:
    """The trained parts of a student as codes: everything rounded as stored.

    `codebooks`, of one kind or the other, holds `scale` (log-scales), `rotation`
    (quaternions), `appearance` (static and view latents), `opacity` (base logits) and `lobes`
    (the lobe decoder's latents).

    Raises:
        InputError: a part is missing, out of range or not finite.
    """
    books: dict[Attribute, Tensor] = {}
    steps: dict[Attribute, float] = {}
    for name, codes in codebooks.items():
        if isinstance(codes, SubVectorCodebooks):
            books[name] = _stored(codes.centers)
        else:
            steps[name] = float(codes.step.detach())
    width = torch.int32 if steps else torch.int16
    coded = CodedScene(
        positions=frame.store(means).cpu(),
        frame=frame,
        indices={name: book.indices.to("cpu", width) for name, book in codebooks.items()},
        codebooks=books,
        steps=steps,
        decoder=_weights(decoder),
        lobe_shape=None if lobe_decoder is None else lobe_decoder.shape,
        lobe_decoder={} if lobe_decoder is None else _weights(lobe_decoder),
        network=None if network is None else _weights(network),
        blend=blend,
        weighting=weighting,
        background=background,
        near=near,
        views=views or [],
        meta=meta or {},
    )
    coded.check()
    return coded


def _weights(module: nn.Module) -> dict[str, Tensor]:
    digits = module.digits if isinstance(module, AppearanceDecoder | LobeDecoder) else DIGITS
    return {
        name: _stored(value, digits if value.ndim == 2 else DIGITS)
        for name, value in module.named_parameters()
    }


def _stored(values: Tensor, digits: int = DIGITS) -> Tensor:
    return to_half(values.detach(), digits).cpu()
