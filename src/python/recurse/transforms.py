"""Transforms as 4 x 4 matrices for column vectors: `translate(0, 1, 0) @ rotate(90, (1, 0, 0))` rotates first."""
from typing import Sequence

import numpy as np


def translate(x: float, y: float, z: float) -> np.ndarray:
    """Translation of the origin to (x, y, z)."""
    matrix = np.eye(4)
    matrix[:3, 3] = x, y, z
    return matrix


def scale(x: float, y: float, z: float) -> np.ndarray:
    """Scaling along the axes."""
    return np.diag([x, y, z, 1.0])


def rotate(degrees: float, axis: Sequence[float]) -> np.ndarray:
    """Rotation about an axis through the origin (Rodrigues' formula)."""
    a = np.asarray(axis, float) / np.linalg.norm(axis)
    cross = np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])
    angle = np.radians(degrees)
    matrix = np.eye(4)
    matrix[:3, :3] += np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    return matrix


def look_at(eye: Sequence[float], target: Sequence[float], up: Sequence[float] = (0, 1, 0)) -> np.ndarray:
    """Matrix of a camera at `eye` that looks at `target`: from camera space (x right, y up, z forward) to the
    world. The handedness is the same as in scene files."""
    eye, target = np.asarray(eye, float), np.asarray(target, float)
    forward = (target - eye) / np.linalg.norm(target - eye)
    right = np.cross(up, forward)
    right /= np.linalg.norm(right)
    matrix = np.eye(4)
    matrix[:3, :4] = np.stack([right, np.cross(forward, right), forward, eye], axis=1)
    return matrix
