// View of a picture: zoom, pan, a marked pixel, and a second picture behind a slider.

class View {
  constructor(canvas, width, height) {
    this.canvas = canvas;
    this.width = width;
    this.height = height;
    this.pictures = [document.createElement("canvas"), null]; // the shown one, and the one compared with it
    this.split = 0.5;
    this.zoom = 1; // size of a pixel of the picture [CSS pixels]
    this.left = this.top = 0; // position of the picture [CSS pixels]
    this.fitted = true;
    this.marked = null; // [x, y], set by a click
    this.hovered = null;
    this.onPixel = () => {};
    this.onSplit = () => {};
    this.onZoom = () => {};
    new ResizeObserver(() => (this.fitted ? this.fit() : this.draw())).observe(canvas.parentElement);
    this.listen();
  }

  get area() { return this.canvas.parentElement.getBoundingClientRect(); }
  /** Pixel whose values are displayed, or null. */
  get pixel() { return this.marked ?? this.hovered; }

  fit() {
    const { width, height } = this.area, border = 24;
    const zoom = Math.min((width - 2 * border) / this.width, (height - 2 * border) / this.height);
    // An integer zoom, if it leaves little empty space, gives all pixels the same size.
    this.zoom = zoom >= 1 && Math.floor(zoom) / zoom > 0.85 ? Math.floor(zoom) : Math.max(zoom, 0.01);
    this.left = Math.round((width - this.width * this.zoom) / 2);
    this.top = Math.round((height - this.height * this.zoom) / 2);
    this.fitted = true;
    this.draw();
  }

  zoomBy(factor, x = this.area.width / 2, y = this.area.height / 2) {
    const zoom = Math.min(Math.max(this.zoom * factor, 0.05), 128);
    this.left = x - (x - this.left) * zoom / this.zoom;
    this.top = y - (y - this.top) * zoom / this.zoom;
    this.zoom = zoom;
    this.fitted = false;
    this.draw();
  }

  pan(dx, dy) {
    this.left += dx;
    this.top += dy;
    this.fitted = false;
    this.draw();
  }

  draw() {
    if (this.pending) return;
    this.pending = true;
    requestAnimationFrame(() => { this.pending = false; this.drawNow(); });
  }

  drawNow() {
    const { width, height } = this.area, density = window.devicePixelRatio || 1;
    const columns = Math.max(Math.round(width * density), 1);
    const rows = Math.max(Math.round(height * density), 1);
    if (this.canvas.width !== columns || this.canvas.height !== rows) {
      this.canvas.width = columns;
      this.canvas.height = rows;
    }
    const context = this.canvas.getContext("2d");
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.clearRect(0, 0, columns, rows);
    context.setTransform(density, 0, 0, density, 0, 0);
    context.imageSmoothingEnabled = this.zoom < 1;
    const [shown, compared] = this.pictures;
    const place = [this.left, this.top, this.width * this.zoom, this.height * this.zoom];
    context.drawImage(shown, ...place);
    if (compared) {
      const x = width * this.split;
      context.save();
      context.beginPath();
      context.rect(x, 0, width - x, height);
      context.clip();
      context.drawImage(compared, ...place);
      context.restore();
      context.fillStyle = "#f0b45a";
      context.fillRect(x - 1, 0, 2, height);
      context.beginPath();
      context.arc(x, height / 2, 9, 0, 2 * Math.PI);
      context.fill();
    }
    if (this.marked) this.drawMark(context);
    this.onZoom(this.zoom);
  }

  drawMark(context) {
    const size = Math.max(this.zoom, 7), middle = ([x, o]) => o + (x + 0.5) * this.zoom - size / 2;
    const x = middle([this.marked[0], this.left]), y = middle([this.marked[1], this.top]);
    for (const [colour, grow] of [["#000", 1.5], ["#fff", 0.5]]) {
      context.strokeStyle = colour;
      context.lineWidth = 1;
      context.strokeRect(x - grow, y - grow, size + 2 * grow, size + 2 * grow);
    }
  }

  /** Pixel at a position of the canvas; null outside of the picture. */
  pixelAt(x, y) {
    const i = Math.floor((x - this.left) / this.zoom), j = Math.floor((y - this.top) / this.zoom);
    return i >= 0 && j >= 0 && i < this.width && j < this.height ? [i, j] : null;
  }

  mark(pixel) {
    this.marked = pixel;
    this.onPixel();
    this.draw();
  }

  /** Moves the marked pixel, initially the centre, by (dx, dy). */
  step(dx, dy) {
    const [x, y] = this.marked ?? [Math.floor(this.width / 2) - dx, Math.floor(this.height / 2) - dy];
    const clamp = (value, size) => Math.min(Math.max(value, 0), size - 1);
    this.mark([clamp(x + dx, this.width), clamp(y + dy, this.height)]);
  }

  setSplit(split) {
    this.split = Math.min(Math.max(split, 0), 1);
    this.onSplit(this.split);
    this.draw();
  }

  listen() {
    let drag = null; // state of a drag of the pointer; null: none
    const place = (event) => {
      const area = this.canvas.getBoundingClientRect();
      return [event.clientX - area.left, event.clientY - area.top];
    };
    const nearSplit = (x) => this.pictures[1] && Math.abs(x - this.area.width * this.split) < 10;
    this.canvas.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      const [x, y] = place(event);
      drag = { x, y, moved: false, split: nearSplit(x) };
      this.canvas.setPointerCapture(event.pointerId);
    });
    this.canvas.addEventListener("pointermove", (event) => {
      const [x, y] = place(event);
      if (drag) {
        if (Math.hypot(x - drag.x, y - drag.y) > 3) drag.moved = true;
        if (drag.split) this.setSplit(x / this.area.width);
        else if (drag.moved) {
          this.pan(x - (drag.lastX ?? drag.x), y - (drag.lastY ?? drag.y));
          [drag.lastX, drag.lastY] = [x, y];
        }
      }
      this.canvas.style.cursor =
        drag?.split || nearSplit(x) ? "ew-resize" : drag?.moved ? "grabbing" : "crosshair";
      this.hovered = this.pixelAt(x, y);
      if (!this.marked) this.onPixel();
    });
    const release = (event) => {
      if (drag && !drag.moved && !drag.split && event.type === "pointerup")
        this.mark(this.pixelAt(...place(event)));
      drag = null;
    };
    this.canvas.addEventListener("pointerup", release);
    this.canvas.addEventListener("pointercancel", release);
    this.canvas.addEventListener("pointerleave", () => {
      this.hovered = null;
      if (!this.marked) this.onPixel();
    });
    this.canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      const lines = event.deltaMode === 1 ? 24 : 1; // some browsers report lines
      this.zoomBy(2 ** (-event.deltaY * lines / 300), ...place(event));
    }, { passive: false });
  }
}
