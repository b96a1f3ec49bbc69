"""The paper's printed file sizes against the codebooks that its text and its release name.

A file has positions, indices, networks and codebooks. The first two are counted as in OMG (Lee et
al. 2025), whose codec is the same: its table 7 gives the bits of a position, its table 6 the share
of the indices' bits that Huffman codes leave.
"""

from dataclasses import replace

from mobilegs.representation.codebooks import CodebookSizes

GAUSSIANS = 470_000  # of the paper's tables, mean of Mip-NeRF 360
POSITION_BITS, HUFFMAN = 18.1, 0.929
# of Eq. 4 in float32; and of Eq. 6 in float16, as released
NETWORK_BYTES = 188_680 + 22_528
ATTRIBUTES = "scale", "rotation", "appearance"
# the paper's table of codebook sizes, in MiB by entries; 7.9 for 4,096 fits neither reading
PRINTED = {64: 3.84, 256: 4.2, 1024: 4.6, 4096: 7.9}
FIVE = CodebookSizes(scale=1024, rotation=1024, appearance=1024, joint_shapes=True)


def file_mib(sizes: CodebookSizes) -> float:
    """Return the size of a file with these codebooks, in MiB."""
    bits, entries = 0, 0
    for name in ATTRIBUTES:
        cut, size = sizes.cuts[name], getattr(sizes, name)
        bits += cut.count * (size - 1).bit_length()
        entries += cut.count * cut.length * size
    each = POSITION_BITS + HUFFMAN * bits
    return (GAUSSIANS * each / 8 + NETWORK_BYTES + 2 * entries) / 2**20


def readings(paper: CodebookSizes) -> list[list[str]]:
    """Return the rows of a table: printed sizes, those of the preset, and those of five books."""
    rows = []
    for size, printed in PRINTED.items():
        eight = file_mib(replace(paper, appearance=size))
        five = file_mib(replace(FIVE, scale=size, rotation=size, appearance=size))
        told = [f"{found:.2f} ({100 * (found / printed - 1):+.0f} %)" for found in (eight, five)]
        rows.append([f"{size:,}", f"{printed:g}", *told])
    return rows
