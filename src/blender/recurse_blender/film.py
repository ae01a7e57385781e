"""The part of a picture without its background."""
import numpy as np

EMITTED = "film_emitted"  # the class of light that comes straight from lamps and sky
LAYER, CLASS = "cryptoobject", f"{EMITTED}=LE"
COVERAGES = [f"CryptoObject{i:02}.{letter}" for i in range(3) for letter in "GA"]


def without_background(channels, shines):
    """Colours times opacity, and opacity, of channels by name: what objects cover of a pixel, and all light but that of
    the sky behind them. `shines`: some object is seen to shine, so that at edges the sky's part of what comes straight
    is an estimate."""
    opacity = np.clip(sum(channels[name] for name in COVERAGES), 0, 1)
    colours = np.stack([channels[name] for name in "RGB"], axis=-1)
    emitted = np.stack([channels[f"{EMITTED}.{letter}"] for letter in "RGB"], axis=-1)
    sky = emitted * (1 - opacity)[..., None] if shines else emitted
    return np.maximum(colours - sky, 0), opacity
