"""Gradient noise of Blender's Noise Texture in three dimensions (Perlin 2002, "Improving Noise", with a hash of Bob
Jenkins)."""
import numpy as np

SCALE = 0.982  # factor that scales the noise to [-1, 1]
MOST_OCTAVES = 15


def _rotated(x, bits):
    return (x << np.uint32(bits)) | (x >> np.uint32(32 - bits))


def _hash(x, y, z, count=3):
    """Hash of three integers, all 0 after the first `count`: the final mix of lookup3."""
    seed = np.uint32(0xdeadbeef + (count << 2) + 13)
    a, b, c = seed + x, seed + y, seed + z
    c = (c ^ b) - _rotated(b, 14)
    a = (a ^ c) - _rotated(c, 11)
    b = (b ^ a) - _rotated(a, 25)
    c = (c ^ b) - _rotated(b, 16)
    a = (a ^ c) - _rotated(c, 4)
    b = (b ^ a) - _rotated(a, 14)
    return (c ^ b) - _rotated(b, 24)


def _gradient(code, x, y, z):
    h = code & np.uint32(15)
    u = np.where(h < 8, x, y)
    v = np.where(h < 4, y, np.where((h == 12) | (h == 14), x, z))
    return np.where(h & 1, -u, u) + np.where(h & 2, -v, v)


def noise(points):
    """Noise in [0, 1], at points (…, 3)."""
    cell = np.floor(points)
    along = points - cell
    corner = cell.astype(np.int64).astype(np.uint32)
    fade = along ** 3 * (along * (along * 6 - 15) + 10)
    total = np.zeros(points.shape[:-1])
    with np.errstate(over="ignore"):  # integers wrap around
        for i in range(8):
            step = np.array([i & 1, i >> 1 & 1, i >> 2], np.uint32)
            code = _hash(*np.moveaxis(corner + step, -1, 0))
            weight = np.where(step, fade, 1 - fade).prod(axis=-1)
            total += weight * _gradient(code, *np.moveaxis(along - step, -1, 0))
    return 0.5 + 0.5 * SCALE * total


def offset(seed):
    """Offset of the coordinates for independent noise with this number."""
    bits = np.full(3, seed, np.float32).view(np.uint32)
    with np.errstate(over="ignore"):
        codes = _hash(bits, np.arange(3, dtype=np.float32).view(np.uint32), np.uint32(0), 2)
    return 100 + 100 * codes.astype(float) / 0xffffffff


def fractal(points, detail, roughness):
    """Sum of octaves, in [0, 1]; a fractional `detail` weights the last octave."""
    detail, roughness = min(max(detail, 0), MOST_OCTAVES), min(max(roughness, 0), 1)
    total, heights = np.zeros(points.shape[:-1]), 0
    for octave in range(int(detail) + 1):
        total += roughness ** octave * noise(points * 2 ** octave)
        heights += roughness ** octave
    part = detail - int(detail)
    if part > 0:
        last = roughness ** (int(detail) + 1)
        more = total + last * noise(points * 2 ** (int(detail) + 1))
        return (1 - part) * total / heights + part * more / (heights + last)
    return total / heights
