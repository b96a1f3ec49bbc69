"""Chromium without a window or a GPU, for benchmarks and tests."""

import os
import shutil
from typing import Any

# Chromium takes the last list only, so this one repeats what Playwright disables. The address bar's
# popups are pages of their own, which every new window loads in the time of the page under test.
DISABLED = [
    "AimEnabled",
    "AvoidCorsURLLoaderRestartOnRedirect",
    "AvoidUnnecessaryBeforeUnloadCheckSync",
    "DestroyProfileOnBrowserClose",
    "HttpsFirstBalancedModeAutoEnable",
    "HttpsUpgrades",
    "LensOverlay",
    "MediaRouter",
    "NetworkTimeServiceQuerying",
    "OptimizationHints",
    "PaintHolding",
    "PreconnectToSearch",
    "ThirdPartyStoragePartitioning",
    "WebUIOmniboxAimPopup",
    "WebUIOmniboxPopup",
]
DRIVERS = {"VK_DRIVER_FILES", "VK_ADD_DRIVER_FILES", "VK_ICD_FILENAMES"}
FLAGS = [
    "--headless=new",
    "--no-sandbox",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    f"--disable-features={','.join(DISABLED)}",
    # WebGPU on a canvas and WebGL2 both work in software only with all of these
    "--enable-unsafe-webgpu",
    "--use-webgpu-adapter=swiftshader",
    "--enable-features=Vulkan",
    "--use-vulkan=swiftshader",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
]


def installed() -> str | None:
    """Return Chromium's path; None if it is not installed."""
    return shutil.which("chromium") or shutil.which("google-chrome")


def launched(playwright: Any, *flags: str) -> Any:
    """Launch a browser, with further `flags`; the caller closes it.

    It draws with the Vulkan device that it brings, so variables that choose others do not count.
    """
    environment = {name: value for name, value in os.environ.items() if name not in DRIVERS}
    return playwright.chromium.launch(
        executable_path=installed(), args=[*FLAGS, *flags], env=environment
    )
