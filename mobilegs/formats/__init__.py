"""The list of formats of other tools. The module NAME has `read_NAME(path) -> Gaussians`.

A module of `Kind` also has `write_NAME(path, gaussians, *, footprint, note)`, without those of the
two that its file does not hold. A module may have `read_NAME_scene(path) -> (Gaussians,
Footprint)`. `open_scene`, `edit`, and the choices of `export --to` and of the batch follow from
this list.
"""

from typing import Literal, get_args

Kind = Literal["ply", "spz", "sog", "glb"]  # read and written
ReadOnly = Literal["splat"]
Export = Literal["html", "site", Kind]  # choices of `mobilegs export --to`
WRITTEN: tuple[Kind, ...] = get_args(Kind)
READ: tuple[str, ...] = (*get_args(Kind), *get_args(ReadOnly))
