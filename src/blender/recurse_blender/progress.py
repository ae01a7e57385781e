"""Parsing of progress lines of the program `recurse`."""
import json
import math


def _number(values, name):
    """Finite number of that name, or None; unknown values are null."""
    value = values.get(name)
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)
    return value if is_number else None


def read_progress(line):
    """Fraction in [0, 1] and text of a line of JSON; None if it is not JSON or has no fraction."""
    try:
        values = json.loads(line)
    except ValueError:
        return None
    if not isinstance(values, dict):
        return None
    fraction, samples, left = (_number(values, name) for name in ("fraction", "samples_per_pixel", "seconds_left"))
    if fraction is None:
        return None
    text = f"Recurse: {values.get('phase') or 'render'}"
    if samples:
        text += f", {samples:.0f} samples"
    if left is not None and left >= 0:
        text += f", {left:.0f} s left"
    return min(max(fraction, 0), 1), text
