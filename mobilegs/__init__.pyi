"""The public names of `mobilegs/__init__.py`, for type checkers."""

from mobilegs.camera import Camera as Camera
from mobilegs.camera import look_at as look_at
from mobilegs.capture.run import CaptureRun as CaptureRun
from mobilegs.capture.run import capture_photos as capture_photos
from mobilegs.data import load_capture as load_capture
from mobilegs.data.dataset import Dataset as Dataset
from mobilegs.data.dataset import Frame as Frame
from mobilegs.data.dataset import View as View
from mobilegs.data.dataset import ViewLoader as ViewLoader
from mobilegs.data.dataset import load_view as load_view
from mobilegs.data.demo.capture import demo_capture as demo_capture
from mobilegs.data.demo.capture import write_capture as write_capture
from mobilegs.errors import InputError as InputError
from mobilegs.evaluate.lpips import lpips_from as lpips_from
from mobilegs.evaluate.metrics import displayed_colors as displayed_colors
from mobilegs.evaluate.metrics import psnr as psnr
from mobilegs.evaluate.metrics import ssim as ssim
from mobilegs.evaluate.metrics import to_bytes as to_bytes
from mobilegs.evaluate.report import evaluate_side_by_side as evaluate_side_by_side
from mobilegs.formats.glb import read_glb as read_glb
from mobilegs.formats.glb import write_glb as write_glb
from mobilegs.formats.ply import read_ply as read_ply
from mobilegs.formats.ply import write_ply as write_ply
from mobilegs.formats.sog import read_sog as read_sog
from mobilegs.formats.sog import write_sog as write_sog
from mobilegs.formats.splat import read_splat as read_splat
from mobilegs.formats.spz import read_spz as read_spz
from mobilegs.formats.spz import write_spz as write_spz
from mobilegs.gaussians import Gaussians as Gaussians
from mobilegs.mgs.codec import decode_mgs as decode_mgs
from mobilegs.mgs.codec import encode_mgs as encode_mgs
from mobilegs.mgs.codec import read_mgs as read_mgs
from mobilegs.mgs.codec import write_mgs as write_mgs
from mobilegs.mgs.lod import with_lod_levels as with_lod_levels
from mobilegs.mgs.quantized_scene import QuantizedScene as QuantizedScene
from mobilegs.pipeline.compress import CompressRun as CompressRun
from mobilegs.pipeline.compress import compress_run as compress_run
from mobilegs.pipeline.export_sorted import SortedExport as SortedExport
from mobilegs.pipeline.export_sorted import export_sorted as export_sorted
from mobilegs.pipeline.train import TrainRun as TrainRun
from mobilegs.pipeline.train import train_run as train_run
from mobilegs.render import render_sorted as render_sorted
from mobilegs.render import render_sortfree as render_sortfree
from mobilegs.render.rendered import Rendered as Rendered
from mobilegs.render.scene import Scene as Scene
from mobilegs.render.sortfree import Weighting as Weighting
from mobilegs.scene_file import inspect_scene as inspect_scene
from mobilegs.scene_file import open_scene as open_scene
from mobilegs.scene_file import write_gaussians as write_gaussians
from mobilegs.train.recipes import Recipe as Recipe
from mobilegs.train.recipes import demo_recipe as demo_recipe
from mobilegs.train.recipes import long_recipe as long_recipe
from mobilegs.train.recipes import short_recipe as short_recipe
from mobilegs.train.recipes import with_method as with_method
from mobilegs.train.recipes import with_settings as with_settings
from mobilegs.train.recipes import with_steps as with_steps
from mobilegs.view.export import export_html as export_html
from mobilegs.view.export import export_site as export_site
from mobilegs.view.serve import Server as Server
from mobilegs.view.wgpu_renderer import WgpuRenderer as WgpuRenderer

PUBLIC: dict[str, tuple[str, ...]]
_HOMES: dict[str, str]
__version__: str
