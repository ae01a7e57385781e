// Boxes of the photon map's tree at a chosen level.

const BOX_EDGES = [0, 1, 2, 3, 4, 5, 6, 7, 0, 2, 1, 3, 4, 6, 5, 7, 0, 4, 1, 5, 2, 6, 3, 7]; // bits of corners: upper x, y, z

class BoxView {
  constructor(view, boxes) {
    Object.assign(this, { view, boxes });
    element("boxPanel").hidden = boxes.count === 0;
    this.isUsed = boxes.count > 0;
    if (!this.isUsed) return;
    const last = boxes.levels.reduce((a, b) => Math.max(a, b), 0);
    Object.assign(element("boxLevel"), { max: last, value: Math.min(6, last) });
    element("boxMap").closest("label").hidden = new Set(boxes.caustic).size < 2;
    for (const name of ["showBoxes", "boxLevel", "boxMap"]) element(name).addEventListener("input", () => this.draw());
    this.draw();
  }

  /** Indices of the boxes at a level, and of leaves above it, so that all photons are in one of them. */
  at(level) {
    const { count, levels, caustic } = this.boxes, map = element("boxMap").value, out = [];
    for (let i = 0; i < count; ++i) {
      const isWanted = map === "all" || Number(map) === caustic[i];
      const isLeaf = i + 1 === count || levels[i + 1] <= levels[i]; // each box comes before its parts
      if (isWanted && (levels[i] === level || (levels[i] < level && isLeaf))) out.push(i);
    }
    return out;
  }

  draw() {
    const { bounds, photons } = this.boxes, level = Number(element("boxLevel").value), shown = this.at(level);
    const counts = shown.map((i) => photons[i]), most = counts.reduce((a, b) => Math.max(a, b), 0);
    element("boxText").textContent = `${level}`;
    element("boxStatus").textContent = `${shown.length} ${shown.length === 1 ? "box" : "boxes"} after ${level} `
      + `${level === 1 ? "split" : "splits"}, at most ${most} photons each`;
    const isShown = element("showBoxes").checked;
    element("view").dataset.boxes = isShown ? shown.length : 0;
    if (!isShown) {
      this.view.replace("boxes", null);
      return;
    }
    const points = new Float32Array(3 * BOX_EDGES.length * shown.length);
    let k = 0;
    for (const i of shown)
      for (const corner of BOX_EDGES)
        for (let c = 0; c < 3; ++c) points[k++] = bounds[6 * i + 3 * (corner >> c & 1) + c];
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(points, 3));
    const material = new THREE.LineBasicMaterial({ color: 0x54d6d6, transparent: true, opacity: 0.8 });
    material.clippingPlanes = this.view.material.clippingPlanes;
    this.view.replace("boxes", new THREE.LineSegments(geometry, material));
  }
}
