"""The page of the live view: its controls and its frames, served by viser.

viser runs callbacks in its own threads. They only record the requests of people; the training
thread renders.
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
from mobilegs.live.frames import BrowserCamera, TrainingCameras

MODES = ("render", "depth", "error", "photo", "photo | render | error")
PHOTO_MODES = MODES[2:]  # seen from the nearest photo's camera instead of the browser's
CHOOSE = "choose one"
FRUSTUM_SIZE = 0.04  # size of a camera, in extents of the scene
BALL_RADIUS = 0.01  # radius of the clickable ball behind it
ORANGE = (250, 150, 50)
QUALITY = 85  # of JPEG
CLOSED_WARNING = r"Queued a \w+ on a closed connection"


class LocalServer(viser.ViserServer):
    """viser's server without its tunnel into the internet, which any page could request."""

    def request_share_url(self, verbose: bool = True) -> str | None:
        return None


class Page:
    """The page that every browser at the address sees, and the requests of its users.

    Attributes:
        address: http address of the page.
        changed: an event, set by every request; the reader clears it.
        paused: True while the training should stand still.
        mode: one of `MODES`.
        with_cameras: True if the training cameras are drawn over the frame.
        cameras: the training cameras.
    """

    def __init__(self, host: str, port: int, dataset: Dataset) -> None:
        """Listen at `host` and `port`, or the next free port; 0 takes any free port."""
        self.changed = threading.Event()
        self.paused = False
        self.mode = MODES[0]
        self.with_cameras = True
        self.cameras = TrainingCameras(dataset)
        with redirect_stdout(io.StringIO()):  # viser prints a box
            self._server = LocalServer(
                host=host, port=port, label=f"mobilegs: {dataset.name}", verbose=False
            )
        self.address = f"http://{host}:{self._server.get_port()}"
        self._set_scene()
        self._set_panel([frame.name for frame in dataset.train])

    def clients(self) -> dict[int, BrowserCamera]:
        """Return the camera of each browser by its permanent number."""
        browsers = {}
        for number, client in self._server.get_clients().items():
            camera = client.camera
            x, y, z = map(float, camera.position)
            browser = BrowserCamera(
                (x, y, z),
                tuple(map(float, transforms.SO3(camera.wxyz).as_matrix().flatten())),
                float(camera.fov),
                int(camera.image_width),
                int(camera.image_height),
            )
            if browser.is_valid:
                browsers[number] = browser
        return browsers

    def send_frame(self, number: int, frame: UInt8[np.ndarray, "h w 3"]) -> None:
        """Fill the canvas of browser `number` if it is still connected."""
        client = self._server.get_clients().get(number)
        if client is None:
            return
        with warnings.catch_warnings():  # viser warns if a browser disconnects now
            warnings.filterwarnings("ignore", CLOSED_WARNING)
            client.scene.set_background_image(frame, "jpeg", jpeg_quality=QUALITY)

    def set_status(self, rows: dict[str, str]) -> None:
        """Show the state of the training as names and values."""
        text = "  \n".join(f"**{name}** {value}" for name, value in rows.items())
        if self._status.content != text:
            self._status.content = text

    def pause(self, paused: bool) -> None:
        self.paused = paused
        self._button.label = "Resume" if paused else "Pause"
        self.changed.set()

    def set_mode(self, mode: str) -> None:
        self.mode = mode
        self._frustums.visible = self.with_cameras and mode not in PHOTO_MODES
        self.changed.set()

    def move_to_photo(self, client: viser.ClientHandle, index: int) -> None:
        """Move the camera of a browser to where training photo `index` was taken."""
        position, target = self.cameras.position_and_target(index)
        with client.atomic():
            client.camera.position = position.numpy()
            client.camera.look_at = target.numpy()
            client.camera.fov = self.cameras.fov(index, client.camera.aspect)

    def close(self) -> None:
        with redirect_stdout(io.StringIO()):
            self._server.stop()

    def _set_scene(self) -> None:
        scene, cameras = self._server.scene, self.cameras
        scene.set_up_direction(cameras.up)
        scene.configure_environment_map(hdri=None)
        first = self._server.initial_camera  # of new browsers
        position, target = cameras.position_and_target(0)
        first.position, first.look_at = position.numpy(), target.numpy()
        first.fov = cameras.fov(0, aspect=1.2)  # of most windows, without the panel
        self._frustums = scene.add_frame("/cameras", show_axes=False)
        for index, camera in enumerate(cameras.cameras):
            to_world = camera.viewmat[:3, :3].T.double().cpu().numpy()
            scene.add_camera_frustum(
                f"/cameras/{index}",
                fov=cameras.fov(index, camera.width / camera.height),
                aspect=camera.width / camera.height,
                scale=FRUSTUM_SIZE * cameras.extent,
                thickness=1.5,
                thickness_units="screen",
                color=ORANGE,
                wxyz=transforms.SO3.from_matrix(to_world).wxyz,
                position=cameras.positions[index].numpy(),
            )
            ball = scene.add_icosphere(
                f"/cameras/{index}/ball",
                radius=BALL_RADIUS * cameras.extent,
                color=ORANGE,
                position=(0.0, 0.0, -2 * BALL_RADIUS * cameras.extent),
                subdivisions=1,
                cast_shadow=False,
                receive_shadow=False,
            )
            # not the frustum: from a photo's position the pointer is always inside it
            ball.on_click(lambda event, index=index: self.move_to_photo(event.client, index))

    def _set_panel(self, names: list[str]) -> None:
        gui = self._server.gui
        gui.configure_theme(dark_mode=True, show_logo=False, show_share_button=False)
        gui.main_panel.dock_right()  # next to the frame, not over it
        self._status = gui.add_markdown("before the first step")
        self._button = gui.add_button("Pause")
        mode = gui.add_dropdown("Show", MODES)
        with_cameras = gui.add_checkbox("Cameras", self.with_cameras)
        photos = gui.add_dropdown("Go to photo", (CHOOSE, *names))
        nearest = gui.add_button("Go to the nearest photo")
        start = gui.add_button("Go back to the start")
        self._button.on_click(lambda _: self.pause(not self.paused))
        mode.on_update(lambda _: self.set_mode(mode.value))

        @with_cameras.on_update
        def _(_: viser.GuiEvent) -> None:
            self.with_cameras = with_cameras.value
            self.set_mode(self.mode)

        @photos.on_update
        def _(event: viser.GuiEvent) -> None:
            if event.client is not None and photos.value != CHOOSE:
                self.move_to_photo(event.client, names.index(photos.value))
                photos.value = CHOOSE  # so that the same photo can be chosen again

        @nearest.on_click
        def _(event: viser.GuiEvent) -> None:
            browser = self.clients().get(event.client_id or 0)
            if event.client is not None and browser is not None:
                self.move_to_photo(event.client, self.cameras.nearest(browser))

        @start.on_click
        def _(event: viser.GuiEvent) -> None:
            if event.client is not None:
                self.move_to_photo(event.client, 0)

        @self._server.on_client_connect
        def _(client: viser.ClientHandle) -> None:
            client.camera.on_update(lambda _: self.changed.set())
            self.changed.set()
