"""Progress bar of a render: a line on standard error, or HTML in notebooks."""
from __future__ import annotations

import html
import sys
from typing import Any, Mapping


def _notebook_display() -> Any:
    """Function display() of IPython in a notebook, else None."""
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython else None
    if shell is None or not hasattr(shell, "kernel"):
        return None
    from IPython.display import display
    return display


class ProgressBar:
    """Shows dictionaries of progress, see Scene.render(). Negative or None `seconds_left` means unknown."""

    WIDTH = 30  # width of the bar [characters]

    def __init__(self) -> None:
        self.fraction, self.phase, self.figures = 0.0, "", ""
        self._display = _notebook_display()
        self._handle: Any = None

    def __call__(self, progress: Mapping[str, Any]) -> None:
        left = progress.get("seconds_left")
        self.fraction = min(max(progress.get("fraction") or 0.0, 0.0), 1.0)
        self.phase = str(progress.get("phase") or "")
        self.figures = f"{progress.get('samples_per_pixel') or 0:.0f} samples, {progress.get('elapsed') or 0:.0f} s"
        if left is not None and left >= 0:
            self.figures += f", {left:.0f} s left"
        self._show()

    def _show(self) -> None:
        if self._display is None:
            print(f"\r{self!r}   ", end="", file=sys.stderr, flush=True)
        elif self._handle is None:
            self._handle = self._display(self, display_id=True)
        else:
            self._handle.update(self)

    def finish(self) -> None:
        """Ends the line; a bar in a notebook stays as it is."""
        if self._display is None:
            print(file=sys.stderr)

    def __repr__(self) -> str:
        full = int(self.WIDTH * self.fraction)
        return f"{self.phase:>8} [{'#' * full}{'.' * (self.WIDTH - full)}] {self.figures}"

    def _repr_html_(self) -> str:
        return (f'{html.escape(self.phase)} <progress value="{self.fraction:.4f}" max="1"></progress> '
                f"{html.escape(self.figures)}")
