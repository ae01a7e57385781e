"""Sums of materials."""
import numpy as np


class Parts:
    """Sum of materials with colours as weights, emitted radiance, and transparency."""

    def __init__(self, materials=(), emission=(0, 0, 0), clear=(0, 0, 0)):
        self.materials = list(materials)  # pairs: weight, and text after "string type"
        self.emission = np.asarray(emission, float)
        self.clear = np.asarray(clear, float)

    def scaled(self, factor):
        """Sum multiplied by a number or a colour."""
        factor = np.ones(3) * factor
        return Parts([(weight * factor, text) for weight, text in self.materials], self.emission * factor,
                     self.clear * factor)

    def __add__(self, other):
        return Parts(self.materials + other.materials, self.emission + other.emission, self.clear + other.clear)
