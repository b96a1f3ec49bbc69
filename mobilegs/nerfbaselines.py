"""mobilegs as a method of NerfBaselines, which trains and measures many methods by one protocol.

`integrations/nerfbaselines_spec.py` registers it. NerfBaselines itself is not imported: its
datasets are dictionaries of arrays, its cameras a row of each array.
"""

import json
import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor

from mobilegs import __version__
from mobilegs.camera import Camera
from mobilegs.data.dataset import Dataset, Frame, ViewLoader, assemble
from mobilegs.device import choose_device
from mobilegs.errors import InputError
from mobilegs.evaluate.metrics import displayed_colors
from mobilegs.formats.ply import read_ply_scene, write_ply
from mobilegs.mgs.codec import write_mgs
from mobilegs.render.levels import usual_level_sigma
from mobilegs.render.scene import Scene
from mobilegs.train.distributed import Team
from mobilegs.train.exposure import exposures_for
from mobilegs.train.loop import next_views
from mobilegs.train.recipes import RECIPES, Recipe, with_settings, with_steps
from mobilegs.train.state_file import read_state, write_state
from mobilegs.train.student.trainer import Student
from mobilegs.train.teacher.trainer import Teacher
from mobilegs.train.threads import torch_on_one_thread

CHECKPOINT, TEACHER, SCENE = "mobilegs.safetensors", "teacher.ply", "scene.mgs"
DEFAULTS = {"preset": "long", "seed": 0, "device": "auto"}


def camera_of(cameras: Any, index: int | None = None) -> Camera:
    """Return a camera of NerfBaselines' arrays, number `index` of them or the only one.

    Its poses are camera-to-world with OpenCV's axes, its intrinsics fx, fy, cx, cy in pixels.
    """
    pose, intrinsics, size = (
        np.asarray(array if index is None else array[index])
        for array in (cameras.poses, cameras.intrinsics, cameras.image_sizes)
    )
    to_world = np.eye(4)
    to_world[:3] = pose.reshape(-1, 4)[:3]
    fx, fy, cx, cy = (float(number) for number in intrinsics.reshape(4))
    K = torch.tensor([[fx, 0, cx], [0, fy, cy], [0, 0, 1]], dtype=torch.float32)
    width, height = (int(number) for number in size.reshape(2))
    viewmat = torch.from_numpy(np.linalg.inv(to_world)).float()
    return Camera(viewmat, K, width, height)


def pixels_of(image: np.ndarray, background: np.ndarray) -> Tensor:
    """Return a photo as bytes, `[h, w, 3]`; a transparent one over `background`, in [0, 255]."""
    if image.dtype != np.uint8:
        image = np.round(255 * np.clip(image, 0, 1)).astype(np.uint8)
    if image.shape[2] == 4:
        alpha = image[..., 3:] / 255
        image = np.round(image[..., :3] * alpha + background * (1 - alpha)).astype(np.uint8)
    return torch.from_numpy(np.ascontiguousarray(image))


def capture_of(dataset: Mapping[str, Any]) -> Dataset:
    """Return a training set of NerfBaselines as a capture. Raises InputError if it has masks."""
    if dataset.get("masks") is not None:
        raise InputError("masks of NerfBaselines are not supported: use a dataset without masks")
    background = dataset["metadata"].get("background_color")
    background = np.zeros(3) if background is None else np.asarray(background, dtype=float)
    root = Path(dataset.get("image_paths_root") or ".")
    frames = [
        Frame(
            Path(path).relative_to(root).as_posix() if Path(path).is_relative_to(root) else path,
            camera_of(dataset["cameras"], index),
            pixels=pixels_of(image, background),
        )
        for index, (path, image) in enumerate(
            zip(dataset["image_paths"], dataset["images"], strict=True)
        )
    ]
    points, colors = dataset.get("points3D_xyz"), dataset.get("points3D_rgb")
    points = np.zeros((0, 3)) if points is None else np.asarray(points)
    colors = np.full(points.shape, 127.5) if colors is None else np.asarray(colors)
    return assemble(
        str(dataset["metadata"].get("scene") or "scene"),
        *(frames, []),
        points=points.astype(np.float64),
        colors=colors.astype(np.float64) / 255,
        background=tuple(float(channel) / 255 for channel in background),  # pyright: ignore
    )


def recipe_of(hparams: Mapping[str, Any]) -> Recipe:
    """Return the recipe of a preset, of `steps` in total, with settings by their paths.

    Values may be texts, as a command line has them.

    Raises InputError for an unknown preset or setting.
    """
    name = hparams["preset"]
    if name not in RECIPES:
        raise InputError(f"there is no preset '{name}': there are {', '.join(RECIPES)}")
    recipe = RECIPES[name]()
    if "steps" in hparams:
        recipe = with_steps(recipe, int(hparams["steps"]))
    own = (*DEFAULTS, "steps")
    return with_settings(
        recipe,
        [
            f"{path}={value if isinstance(value, str) else json.dumps(value)}"
            for path, value in hparams.items()
            if path not in own
        ],
    )


class MobileGS:
    """The method of NerfBaselines: the steps of the teacher, then those of the student.

    Its images are those of the teacher, then those of the student; at the end, of the file. A
    checkpoint is a folder: the state, the teacher once it is trained, and the finished scene.mgs.
    """

    def __init__(
        self,
        *,
        checkpoint: str | None = None,
        train_dataset: Mapping[str, Any] | None = None,
        config_overrides: Mapping[str, Any] | None = None,
    ) -> None:
        """Begin a training, or continue that of `checkpoint`; without photos it only renders.

        `config_overrides` are `preset`, `seed`, `device`, `steps` in total, and settings of the
        recipe by their paths, such as `student.quantization.target_mb`. Raises InputError if one is
        invalid, and if there is neither a checkpoint nor a dataset.
        """
        self.checkpoint = None if checkpoint is None else Path(checkpoint)
        state = {} if self.checkpoint is None else read_state(self.checkpoint / CHECKPOINT)
        self.hparams = state.get("hparams", DEFAULTS) | dict(config_overrides or {})
        self.seed = int(self.hparams["seed"])
        self.recipe = recipe_of(self.hparams)
        self.loader: ViewLoader | None = None
        if train_dataset is not None:
            self.capture = capture_of(train_dataset)
            self.loader = ViewLoader(self.capture.train)
        elif state:
            self.capture = _capture_without_photos(state["capture"])
        else:
            raise InputError("give a training dataset or a checkpoint")
        self.team = Team(choose_device(self.hparams["device"]))
        self.teacher: Scene | None = None
        self.loaded_step = state.get("step")
        self._scene: tuple[int, Scene] | None = None
        if state.get("stage") == "student":
            assert self.checkpoint is not None
            self.teacher = self._read_teacher(self.checkpoint / TEACHER)
        self.stage = self._begin(restored=bool(state))
        if state:
            self.stage.restore(state["state"])

    @classmethod
    def get_method_info(cls) -> dict[str, Any]:
        """Return what the method needs of a dataset, and gives."""
        return {
            "method_id": "",  # the registry knows it
            "required_features": frozenset(("color", "points3D_xyz", "points3D_rgb")),
            "supported_camera_models": frozenset(("pinhole",)),
            "supported_outputs": ("color",),
            "can_resume_training": True,
        }

    def get_info(self) -> dict[str, Any]:
        """Return the number of steps and the settings that differ from the preset."""
        loaded = None if self.checkpoint is None else str(self.checkpoint)
        return {
            **self.get_method_info(),
            "num_iterations": self.recipe.teacher.steps + self.recipe.student.steps,
            "loaded_step": self.loaded_step,
            "loaded_checkpoint": loaded,
            "hparams": {**self.hparams, "mobilegs": __version__},
        }

    @property
    def step(self) -> int:
        """Steps that are done, of both stages."""
        before = self.recipe.teacher.steps if isinstance(self.stage, Student) else 0
        return before + self.stage.done

    def train_iteration(self, step: int) -> dict[str, float]:
        """Take step number `step`, from 0; return its loss and PSNR."""
        if self.loader is None:
            raise InputError("this checkpoint was opened without photos: it only renders")
        if step != self.step:
            raise InputError(f"step {step} is not the next one, {self.step}")
        if isinstance(self.stage, Teacher) and self.stage.done == self.stage.steps:
            self.teacher = self.stage.scene()
            self.stage = self._begin()
        seed = 2 * self.seed + isinstance(self.stage, Student)
        with torch_on_one_thread(wanted=self.stage.runs_kernels):
            result = self.stage.advance(next_views(self.stage, self.loader, self.team, seed))
        psnr = -10 * math.log10(max(float(result.mse), 1e-10))
        return {"loss": float(result.loss), "psnr": psnr, "num_gaussians": float(self.stage.count)}

    @torch.no_grad()
    def render(self, camera: Any, *, options: Any = None) -> dict[str, np.ndarray]:
        """Return the image of a camera: `color`, `[h, w, 3]` in [0, 1], as 8 bits would show it."""
        if self._scene is None or self._scene[0] != self.step:
            self._scene = self.step, self.stage.scene()
        view = camera_of(camera).to(self.team.device)
        scene = self._scene[1]
        level_sigma = usual_level_sigma(soft_edge=scene.footprint.soft_edge)
        rendered = scene.render(view, level_sigma=level_sigma)
        return {"color": displayed_colors(rendered.image).cpu().numpy()}

    def save(self, path: str) -> None:
        """Write a checkpoint into the folder `path`, with scene.mgs once everything is trained."""
        folder = Path(path)
        folder.mkdir(parents=True, exist_ok=True)
        if self.teacher is not None:
            write_ply(folder / TEACHER, self.teacher.gaussians, footprint=self.teacher.footprint)
        content = {
            "hparams": self.hparams,
            "step": self.step,
            "stage": self.stage.name,
            "state": self.stage.state(),
            "capture": _capture_state(self.capture),
        }
        write_state(folder / CHECKPOINT, content)
        if isinstance(self.stage, Student) and self.stage.done == self.stage.steps:
            write_mgs(folder / SCENE, self.stage.quantized_scene())

    def get_train_embedding(self, index: int) -> None:
        """Return None: there are no embeddings."""

    def close(self) -> None:
        """End the threads that decode photos."""
        if self.loader is not None:
            self.loader.close()

    def _begin(self, *, restored: bool = False) -> Teacher | Student:
        """Return the first stage, or the student of a teacher; a restored one has its exposures."""
        seed, capture, team = self.seed, self.capture, self.team
        if self.teacher is None:
            config = self.recipe.teacher
            if (
                self.loader is None
            ):  # Gaussians on a far sphere would start with the photos' colours
                config = replace(config, far_splats=0)
            return Teacher(config, capture, seed=seed, device=team.device, team=team)
        exposures = None
        if not restored:
            learned = self.recipe.student.exposure
            exposures, _ = exposures_for(learned, self.teacher, capture.train)
        return Student(
            self.recipe.student,
            self.teacher,
            [frame.camera for frame in capture.train],
            extent=capture.extent,
            seed=seed,
            team=team,
            exposures=exposures,
        )

    def _read_teacher(self, path: Path) -> Scene:
        gaussians, footprint = read_ply_scene(path)
        return Scene(
            gaussians.to(self.team.device),
            footprint=footprint,
            background=self.capture.background.to(self.team.device),
            near=self.capture.near,
        )


def _capture_state(capture: Dataset) -> dict[str, Any]:
    """Return what a student needs of a capture without its photos."""
    cameras = [frame.camera for frame in capture.train]
    return {
        "name": capture.name,
        "names": [frame.name for frame in capture.train],
        "viewmats": torch.stack([camera.viewmat for camera in cameras]),
        "K": torch.stack([camera.K for camera in cameras]),
        "sizes": [[camera.width, camera.height] for camera in cameras],
        "points": capture.points,
        "colors": capture.colors,
        "background": capture.background,
    }


def _capture_without_photos(state: Mapping[str, Any]) -> Dataset:
    frames = [
        Frame(name, Camera(viewmat, K, *size))
        for name, viewmat, K, size in zip(
            state["names"], state["viewmats"], state["K"], state["sizes"], strict=True
        )
    ]
    return assemble(
        *(state["name"], frames, []),
        points=state["points"].double().numpy(),
        colors=state["colors"].double().numpy(),
        background=tuple(state["background"].tolist()),
    )
