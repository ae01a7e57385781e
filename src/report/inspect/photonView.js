// Photons of the map: points in the scene, and the density estimate at a clicked point beside path tracing.

const CAUSTIC = 128;

class PhotonView {
  /** Creates the view of `photons`, whose arrays are decoded. */
  constructor(view, data, photons) {
    Object.assign(this, { view, data, photons });
    const { count, inMap, name, limit } = photons;
    element("photonCount").textContent = inMap === 0 ? "The integrator stores no photons; use photonmap."
      : `${count === inMap ? "All" : `${count} of`} ${inMap} ${name} of the integrator's last pass`
        + (count === inMap ? "." : `, each represents ${Math.round(inMap / count)}.`) + ` Limit: --shown-photons ${limit}.`;
    element("photonTools").hidden = count === 0;
    element("photonColour").querySelector("[value=depth]").hidden = data.depths === 0;
    this.references = data.references.map((r) => ({ ...r, point: vector(r.position), normal: vector(r.normal), name: r.object }));
    this.drawReferences();
    element("atPixel").addEventListener("click", () => this.pick(this.offered));
    element("curveAxis").addEventListener("input", () => this.drawCurve());
    for (const name of ["showPhotons", "photonColour", "photonSize"])
      element(name).addEventListener("input", () => this.draw());
    element("radius").addEventListener("input", () => this.setRadius(this.radiusAt(Number(element("radius").value))));
    element("number").addEventListener("input", () => this.setNumber(this.numberAt(Number(element("number").value))));
  }

  /** Colours of the photons, three bytes each. */
  colours(mode) {
    const { count, kinds, powers, depths } = this.photons, out = new Uint8Array(3 * count);
    const rgb = (colour) => new THREE.Color(colour).toArray().map((x) => Math.round(255 * x)), palette = new Map();
    const STEPS = 64, brightest = mode === "power" ? this.brightPower() : 1;
    const keyOf = {
      class: (i) => kinds[i] & ~CAUSTIC,
      map: (i) => kinds[i] & CAUSTIC,
      depth: (i) => depths[i],
      power: (i) => Math.round(STEPS * Math.min(1,
        Math.sqrt(luminance(powers[3 * i], powers[3 * i + 1], powers[3 * i + 2]) / brightest))),
    }[mode];
    const colourOf = {
      class: (key) => rgb(classColour(key)),
      depth: (key) => rgb(this.depthColour(key)),
      map: (key) => rgb(key ? "#ffd166" : "#4fa3ff"),
      power: (key) => rgb(new THREE.Color().setHSL(0.66 * (1 - key / STEPS), 1, 0.55)),
    }[mode];
    for (let i = 0; i < count; ++i) {
      const key = keyOf(i);
      if (!palette.has(key)) palette.set(key, colourOf(key));
      out.set(palette.get(key), 3 * i);
    }
    return out;
  }

  /** Colour of a depth from 1, blue, on; 0: not known. */
  depthColour(depth) {
    const last = Math.max(2, this.data.depths);
    return depth === 0 ? "#9aa2b1" : `hsl(${Math.round(220 * (1 - (depth - 1) / (last - 1)))}, 95%, 60%)`;
  }

  /** Lists the colours of the depths that occur, with their numbers of photons. */
  listDepths() {
    const isShown = element("photonColour").value === "depth", counts = new Map();
    element("depthLegend").hidden = !isShown;
    if (!isShown) return;
    for (const depth of this.photons.depths) counts.set(depth, (counts.get(depth) ?? 0) + 1);
    element("depthLegend").replaceChildren(...[...counts].sort((a, b) => a[0] - b[0]).map(([depth, count]) => {
      const item = document.createElement("li"), isLast = depth === this.data.depths;
      const name = depth === 0 ? "not known" : `${depth}${isLast ? " or more" : ""}`;
      item.append(swatch(this.depthColour(depth)), ` ${name}: ${count}`);
      return item;
    }));
  }

  draw() {
    const { count, positions } = this.photons;
    this.listDepths();
    if (!element("showPhotons").checked || count === 0) {
      this.view.replace("photons", null);
      return;
    }
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(positions, 3));
    geometry.setAttribute("color", new THREE.BufferAttribute(this.colours(element("photonColour").value), 3, true));
    const material = new THREE.PointsMaterial({ vertexColors: THREE.VertexColors, sizeAttenuation: false,
      size: Number(element("photonSize").value) });
    material.clippingPlanes = this.view.material.clippingPlanes;
    this.view.replace("photons", new THREE.Points(geometry, material));
  }

  /** Power that one photon in a hundred exceeds: the 99 % quantile. */
  brightPower() {
    const { powers, count } = this.photons, all = new Float32Array(count);
    for (let i = 0; i < count; ++i) all[i] = luminance(powers[3 * i], powers[3 * i + 1], powers[3 * i + 2]);
    return all.sort()[Math.floor(0.99 * (count - 1))] || 1;
  }

  /** Draws the points at which path tracing has estimated the irradiance. */
  drawReferences() {
    if (this.references.length === 0 || this.photons.count === 0) return;
    const geometry = new THREE.BufferGeometry().setFromPoints(this.references.map((r) => r.point));
    this.view.replace("references", new THREE.Points(geometry,
      new THREE.PointsMaterial({ color: 0xffffff, size: 6, sizeAttenuation: false })));
  }

  /** Reference point within a few pixels of a clicked point; undefined if there is none. */
  nearReference({ point }) {
    const NEAR = 10, { clientWidth, clientHeight } = this.view.canvas; // [pixels]
    const place = (p) => {
      const v = p.clone().project(this.view.camera);
      return [v.x * clientWidth / 2, v.y * clientHeight / 2];
    };
    const [x, y] = place(point), R = this.data.radius;
    const away = (r) => Math.hypot(place(r.point)[0] - x, place(r.point)[1] - y);
    return this.references.filter((r) => away(r) < NEAR && r.point.distanceTo(point) < 0.1 * R)
      .sort((a, b) => away(a) - away(b))[0];
  }

  /** Offers the estimate at the reference point of a pixel, if it has one. */
  offerReference(pixel) {
    this.offered = this.references.find((r) => r.x === pixel.x && r.y === pixel.y);
    element("atPixel").disabled = !this.offered;
  }

  /** Collects the photons on the side of a surface that was clicked. `irradiance` and `error`: by path tracing, at
   * reference points only. */
  pick({ point, normal, name, irradiance, error, samples, isSpecular = false }) {
    if (this.photons.count === 0) return;
    this.estimate = new Estimate(this.photons, this.view.mesh, { point, normal }, this.data.radius);
    this.reference = irradiance ? { value: irradiance, y: luminance(...irradiance), error, samples } : null;
    Object.assign(this, { point, normal, name, isSpecular, answer: null });
    element("estimate").hidden = false;
    this.limits = [this.estimate.smallest, this.estimate.largest];
    this.setNumber(Math.min(100, this.estimate.found.length));
    if (this.data.live && !irradiance) this.ask(point, normal);
  }

  /** Asks the program that renders for path tracing at this very point. */
  async ask(point, normal) {
    const world = (v) => [v.x * this.data.mirror, v.y, v.z].join();
    const query = new URLSearchParams({ position: world(point), normal: world(normal) });
    this.answer = "the program is asked";
    this.setRadius(this.radius);
    const answer = await fetch(`reference?${query}`).then((a) => (a.ok ? a.json() : a.text()), () => "the render has ended");
    if (this.point !== point) return; // another one has been clicked
    this.answer = typeof answer === "string" ? answer : null;
    if (!this.answer)
      this.reference = { value: answer.irradiance, y: luminance(...answer.irradiance), error: answer.error,
        samples: answer.samples };
    element("view").dataset.reference = this.answer ?? this.reference.y;
    this.setRadius(this.radius);
  }

  radiusAt(slider) { return this.limits[0] * (this.limits[1] / this.limits[0]) ** slider; }
  numberAt(slider) { return Math.max(1, Math.round(this.estimate.found.length ** slider)); }

  setNumber(number) { this.setRadius(this.estimate.radiusOf(number)); }

  setRadius(radius) {
    this.radius = radius;
    const { value, y, count, error, covered } = this.estimate.at(radius);
    element("radius").value = this.radiusPart(radius);
    element("radiusText").textContent = numberText(radius);
    element("number").value = this.numberPart(count);
    element("numberText").textContent = count;
    const rows = [["surface", this.name],
      ["position", worldText(this.data, this.point.toArray())],
      ["irradiance, red green blue", value.map(numberText).join("  ")],
      ["luminance", `${numberText(y)} ± ${numberText(error)}`],
      ["noise", y > 0 ? `${(100 * error / y).toFixed(0)} %` : "–"],
      ["kernel on the surface", `${(100 * covered).toFixed(0)} %`]];
    if (this.isSpecular) rows.splice(1, 0, ["photons", "none are stored here: the surface only reflects and refracts as mirrors and glass do"]);
    const { reference } = this;
    if (reference)
      rows.push(["path tracing, red green blue", reference.value.map(numberText).join("  ")],
        [`luminance by ${reference.samples} paths`, `${numberText(reference.y)} ± ${numberText(reference.error)}`],
        ["difference", reference.y > 0 ? `${(100 * (y / reference.y - 1)).toFixed(1)} %, `
          + `${((y - reference.y) / Math.hypot(error, reference.error)).toFixed(1)} standard errors` : "–"]);
    else if (this.data.live) rows.push(["path tracing", this.answer ?? "–"]);
    else rows.push(["path tracing", this.references.length > 0 ? "at the white points only" : "–"]);
    element("estimateText").replaceChildren(...rows.flatMap(([name, text]) => {
      const dt = document.createElement("dt"), dd = document.createElement("dd");
      dt.textContent = name;
      dd.textContent = text;
      return [dt, dd];
    }));
    this.drawCurve();
    this.drawSupport(count);
  }

  radiusPart(radius) { return Math.log(radius / this.limits[0]) / Math.log(this.limits[1] / this.limits[0]); }
  numberPart(count) { return count > 0 ? Math.log(count) / Math.log(Math.max(2, this.estimate.found.length)) : 0; }

  /** Draws irradiance against radius or number, with a band of one standard error on both sides, and path tracing. */
  drawCurve() {
    if (!this.estimate) return;
    const canvas = element("curve"), context = canvas.getContext("2d"), { width, height } = canvas, STEPS = 80;
    const isByNumber = element("curveAxis").value === "number", { reference } = this;
    const points = Array.from({ length: STEPS + 1 }, (_, i) => {
      const e = this.estimate.at(this.radiusAt(i / STEPS));
      return { ...e, x: isByNumber ? this.numberPart(e.count) : i / STEPS };
    });
    const LEFT = 44, BOTTOM = 18;
    const top = 1.1 * Math.max(1e-30, reference ? reference.y + reference.error : 0,
      ...points.slice(STEPS / 4).map((p) => p.y + p.error));
    const place = (x, y) => [LEFT + x * (width - LEFT - 8),
      height - BOTTOM - Math.min(1.05, Math.max(0, y / top)) * (height - BOTTOM - 6)];
    const band = (upper, lower, style) => {
      context.beginPath();
      for (const p of [...upper, ...lower.reverse()]) context.lineTo(...p);
      context.fillStyle = style;
      context.fill();
    };
    const line = (all, style) => {
      context.beginPath();
      for (const p of all) context.lineTo(...p);
      Object.assign(context, { strokeStyle: style, lineWidth: 2 });
      context.stroke();
    };
    context.clearRect(0, 0, width, height);
    this.drawAxes(context, place, top, isByNumber);
    if (reference) {
      const level = (y) => [place(0, y), place(1, y)];
      band(level(reference.y + reference.error), level(reference.y - reference.error), "#5fd38d55");
      line(level(reference.y), "#5fd38d");
    }
    band(points.map((p) => place(p.x, p.y + p.error)), points.map((p) => place(p.x, p.y - p.error)), "#4fa3ff55");
    line(points.map((p) => place(p.x, p.y)), "#4fa3ff");
    const now = Number(element(isByNumber ? "number" : "radius").value);
    line([place(now, 0), place(now, top)], "#f0b45a");
  }

  /** Draws the axes: three numbers each. */
  drawAxes(context, place, top, isByNumber) {
    Object.assign(context, { fillStyle: "#9aa2b1", font: "11px sans-serif", strokeStyle: "#9aa2b140", lineWidth: 1 });
    for (const part of [0, 0.5, 1]) {
      const [x, y] = place(part, 0), text = isByNumber ? String(this.numberAt(part)) : numberText(this.radiusAt(part));
      context.textAlign = ["left", "center", "right"][2 * part];
      context.fillText(text, x, y + 13);
      const value = part * top / 1.1, [left, up] = place(0, value);
      context.textAlign = "right";
      // Without light there is no scale.
      if (part === 0 || top > 1e-25) context.fillText(numberText(value), left - 5, up + 4);
      context.beginPath();
      context.moveTo(left, up);
      context.lineTo(place(1, value)[0], up);
      context.stroke();
    }
  }

  /** Draws the support, its photons, and the directions that they came from. */
  drawSupport(count) {
    const { positions, directions } = this.photons, group = new THREE.Group(), dots = [], lines = [];
    for (const { index } of this.estimate.found.slice(0, Math.min(count, 1000))) {
      const p = new THREE.Vector3().fromArray(positions, 3 * index);
      dots.push(p);
      lines.push(p, p.clone().addScaledVector(new THREE.Vector3().fromArray(directions, 3 * index), this.radius / 127 / 2));
    }
    const colour = 0xf0b45a, plain = (points) => new THREE.BufferGeometry().setFromPoints(points);
    group.add(new THREE.LineSegments(plain(lines), new THREE.LineBasicMaterial({ color: 0xffe0a8 })));
    group.add(new THREE.Points(plain(dots), new THREE.PointsMaterial({ color: colour, size: 5, sizeAttenuation: false })));
    const disc = new THREE.Mesh(new THREE.CircleBufferGeometry(this.radius, 48),
      new THREE.MeshBasicMaterial({ color: colour, transparent: true, opacity: 0.25, side: THREE.DoubleSide, depthWrite: false }));
    disc.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), this.normal);
    disc.position.copy(this.point).addScaledVector(this.normal, 0.002 * this.data.radius);
    group.add(disc);
    this.view.replace("support", group);
  }
}
