"""Removal of an image's background, for a transparent film."""
import numpy as np

EMITTED = "film_emitted"  # path class of light straight from lamps and sky
LAYER, CLASS = "cryptoobject", f"{EMITTED}=LE"
COVERAGES = [f"CryptoObject{i:02}.{letter}" for i in range(3) for letter in "GA"]


def without_background(channels, shines):
    """Premultiplied colours, and opacity, from channels by name. Opacity is the coverage of a pixel by objects; colours
    are all light except directly visible sky. `shines`: some object is visibly emissive, so that at edges the sky's
    fraction of the directly visible light is an estimate."""
    opacity = np.clip(sum(channels[name] for name in COVERAGES), 0, 1)
    colours = np.stack([channels[name] for name in "RGB"], axis=-1)
    emitted = np.stack([channels[f"{EMITTED}.{letter}"] for letter in "RGB"], axis=-1)
    sky = emitted * (1 - opacity)[..., None] if shines else emitted
    return np.maximum(colours - sky, 0), opacity
