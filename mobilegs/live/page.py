"""The page in the browser, by viser: what is asked there, and what is shown.

viser runs callbacks in threads of its own. They only note what was asked; drawing is up to the
thread that trains.
"""

import io
import threading
import warnings
from contextlib import redirect_stdout

import numpy as np
import viser
from jaxtyping import UInt8
from viser import transforms

from mobilegs.data.dataset import Dataset
from mobilegs.live.frames import Eye, Viewpoints

SHOWN = ("picture", "depth", "error", "photo", "photo | picture | error")
WITH_PHOTO = SHOWN[2:]  # what is drawn from the nearest photo's camera instead of the browser's
CHOOSE = "choose one"
FRUSTUM = 0.04  # size of a camera, in extents of the scene
BALL = 0.01  # radius of the ball behind it, on which one clicks
ORANGE = (250, 150, 50)
QUALITY = 85  # of JPEG
GONE = r"Queued a \w+ on a closed connection"


class LocalServer(viser.ViserServer):
    """viser's server, without its tunnel into the internet, which any page could ask for."""

    def request_share_url(self, verbose: bool = True) -> str | None:
        """Share nothing."""
        return None


class Page:
    """What every browser that opens the address sees, and what was asked for there.

    Attributes:
        address: to open in a browser.
        asked: set whenever something was; to be cleared by who waits for it.
        paused: whether training is to stand still.
        shown: one of `SHOWN`.
        with_cameras: whether the training cameras are drawn over the picture.
        views: the training cameras.
    """

    def __init__(self, host: str, port: int, dataset: Dataset) -> None:
        """Listen at `host` and `port`, or the next one that is free (0: any that is)."""
        self.asked = threading.Event()
        self.paused = False
        self.shown = SHOWN[0]
        self.with_cameras = True
        self.views = Viewpoints(dataset)
        with redirect_stdout(io.StringIO()):  # viser prints a box; the address is for us to say
            self._server = LocalServer(
                host=host, port=port, label=f"mobilegs: {dataset.name}", verbose=False
            )
        self.address = f"http://{host}:{self._server.get_port()}"
        self._set_scene()
        self._set_panel([frame.name for frame in dataset.train])

    def eyes(self) -> dict[int, Eye]:
        """Where each browser looks from, by a number that it keeps."""
        found = {}
        for number, client in self._server.get_clients().items():
            camera = client.camera
            x, y, z = map(float, camera.position)
            eye = Eye(
                (x, y, z),
                tuple(map(float, transforms.SO3(camera.wxyz).as_matrix().flatten())),
                float(camera.fov),
                int(camera.image_width),
                int(camera.image_height),
            )
            if eye.usable:
                found[number] = eye
        return found

    def show(self, number: int, picture: UInt8[np.ndarray, "h w 3"]) -> None:
        """Fill the canvas of a browser, if it is still there."""
        client = self._server.get_clients().get(number)
        if client is None:
            return
        with warnings.catch_warnings():  # viser warns of browsers that close just now
            warnings.filterwarnings("ignore", GONE)
            client.scene.set_background_image(picture, "jpeg", jpeg_quality=QUALITY)

    def tell(self, rows: dict[str, str]) -> None:
        """Say how the training stands."""
        text = "  \n".join(f"**{name}** {value}" for name, value in rows.items())
        if self._figures.content != text:
            self._figures.content = text

    def pause(self, paused: bool) -> None:
        """Let training stand still, or go on."""
        self.paused = paused
        self._button.label = "Resume" if paused else "Pause"
        self.asked.set()

    def choose(self, shown: str) -> None:
        """Show something else."""
        self.shown = shown
        self._frustums.visible = self.with_cameras and shown not in WITH_PHOTO
        self.asked.set()

    def go(self, client: viser.ClientHandle, index: int) -> None:
        """Take a browser's camera, whose user asks for it, to where a photo was taken."""
        position, target = self.views.stand(index)
        with client.atomic():
            client.camera.position = position.numpy()
            client.camera.look_at = target.numpy()
            client.camera.fov = self.views.fov(index, client.camera.aspect)

    def close(self) -> None:
        """Stop listening."""
        with redirect_stdout(io.StringIO()):
            self._server.stop()

    def _set_scene(self) -> None:
        scene, views = self._server.scene, self.views
        scene.set_up_direction(views.up.numpy())
        scene.configure_environment_map(hdri=None)
        first = self._server.initial_camera  # of a browser that connects, and never again
        position, target = views.stand(0)
        first.position, first.look_at = position.numpy(), target.numpy()
        first.fov = views.fov(0, aspect=1.2)  # of most windows beside the panel
        self._frustums = scene.add_frame("/cameras", show_axes=False)
        for index, camera in enumerate(views.cameras):
            to_world = camera.viewmat[:3, :3].T.double().cpu().numpy()
            scene.add_camera_frustum(
                f"/cameras/{index}",
                fov=views.fov(index, camera.width / camera.height),
                aspect=camera.width / camera.height,
                scale=FRUSTUM * views.extent,
                thickness=1.5,
                thickness_units="screen",
                color=ORANGE,
                wxyz=transforms.SO3.from_matrix(to_world).wxyz,
                position=views.positions[index].numpy(),
            )
            ball = scene.add_icosphere(
                f"/cameras/{index}/ball",
                radius=BALL * views.extent,
                color=ORANGE,
                position=(0.0, 0.0, -2 * BALL * views.extent),
                subdivisions=1,
                cast_shadow=False,
                receive_shadow=False,
            )
            # who stands where a photo was taken is within the frustum, and would always point at it
            ball.on_click(lambda event, index=index: self.go(event.client, index))

    def _set_panel(self, names: list[str]) -> None:
        gui = self._server.gui
        gui.configure_theme(dark_mode=True, show_logo=False, show_share_button=False)
        gui.main_panel.dock_right()  # beside the picture, not over it
        self._figures = gui.add_markdown("before the first step")
        self._button = gui.add_button("Pause")
        shown = gui.add_dropdown("Show", SHOWN)
        cameras = gui.add_checkbox("Cameras", self.with_cameras)
        photos = gui.add_dropdown("Go to photo", (CHOOSE, *names))
        nearest = gui.add_button("Go to the nearest photo")
        start = gui.add_button("Go back to the start")
        self._button.on_click(lambda _: self.pause(not self.paused))
        shown.on_update(lambda _: self.choose(shown.value))

        @cameras.on_update
        def _(_: viser.GuiEvent) -> None:
            self.with_cameras = cameras.value
            self.choose(self.shown)

        @photos.on_update
        def _(event: viser.GuiEvent) -> None:
            if event.client is not None and photos.value != CHOOSE:
                self.go(event.client, names.index(photos.value))
                photos.value = CHOOSE  # so that the same one can be chosen again

        @nearest.on_click
        def _(event: viser.GuiEvent) -> None:
            eye = self.eyes().get(event.client_id or 0)
            if event.client is not None and eye is not None:
                self.go(event.client, self.views.nearest(eye))

        @start.on_click
        def _(event: viser.GuiEvent) -> None:
            if event.client is not None:
                self.go(event.client, 0)

        @self._server.on_client_connect
        def _(client: viser.ClientHandle) -> None:
            client.camera.on_update(lambda _: self.asked.set())
            self.asked.set()
