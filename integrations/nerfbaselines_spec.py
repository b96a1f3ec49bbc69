"""Registers mobilegs with NerfBaselines: `nerfbaselines install --spec nerfbaselines_spec.py`."""

from nerfbaselines import register  # pyright: ignore[reportMissingImports]

register(
    {
        "id": "mobilegs",
        "method_class": "mobilegs.nerfbaselines:MobileGS",
        "conda": {
            "environment_name": "mobilegs",
            "python_version": "3.11",
            "install_script": "pip install 'mobilegs[cuda]' 'numpy<2'",
        },
        "metadata": {
            "name": "mobilegs",
            "description": "Sort-free Gaussian splats of a few megabytes, after Mobile-GS (ICLR "
            "2026): a sorted teacher is distilled into a student that needs no order, which is "
            "pruned, quantised and entropy coded.",
            "paper_title": "Mobile-GS: Real-time Gaussian Splatting for Mobile Devices",
        },
        "presets": {
            "short": {"preset": "short"},
            "paper": {"preset": "paper"},
            "release": {"preset": "release"},
        },
    }
)
