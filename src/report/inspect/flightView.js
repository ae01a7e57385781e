// Flight of light: recorded light paths as moving points, which bounce and leave a dot where they are stored. Time is
// measured in scene radii that the light has flown.

const ESCAPE = 3, STORED = 4; // bits of LightVertexKind, and of stored vertices

class FlightView {
  constructor(view, data, paths) {
    Object.assign(this, { view, data, paths, time: 0, isPlaying: false });
    const { count } = paths;
    element("flightPanel").hidden = count === 0;
    this.isUsed = count > 0;
    if (!this.isUsed) return;
    this.shortenEscapes();
    this.listClasses();
    this.measure();
    this.choose();
    element("play").addEventListener("click", () => this.play(!this.isPlaying));
    element("flightTime").addEventListener("input", () => this.setTime(Number(element("flightTime").value) * this.end));
    for (const name of ["flightClass", "flightMode"])
      element(name).addEventListener("input", () => {
        this.measure();
        this.choose();
        this.setTime(Math.min(this.time, this.end));
      });
    element("trail").addEventListener("input", () => this.draw());
  }

  /** Ends light that leaves the scene after one radius. */
  shortenEscapes() {
    const { count, positions, previous, kinds } = this.paths;
    for (let i = 0; i < count; ++i) {
      if ((kinds[i] & 3) !== ESCAPE) continue;
      const from = new THREE.Vector3().fromArray(positions, 3 * previous[i]), to = new THREE.Vector3().fromArray(positions, 3 * i);
      from.addScaledVector(to.sub(from).normalize(), this.data.radius).toArray(positions, 3 * i);
    }
  }

  listClasses() {
    const stored = new Set();
    for (let i = 0; i < this.paths.count; ++i) if (this.paths.kinds[i] & STORED) stored.add(this.paths.classes[i]);
    const options = [...stored].sort((a, b) => a - b).map((c) => new Option(this.data.classes[c]?.name ?? "other", c));
    element("flightClass").replaceChildren(new Option("all light", "all"), ...options);
  }

  /** Computes the time of each vertex. A stream starts its paths one after the other, a pulse all at once. */
  measure() {
    const { count, positions, previous, paths } = this.paths, STREAM = 12;
    const pause = element("flightMode").value === "stream" ? STREAM / Math.max(1, paths) : 0;
    this.times = new Float32Array(count);
    let starts = 0;
    for (let i = 0; i < count; ++i) {
      const p = previous[i];
      this.times[i] = p < 0 ? pause * starts++ : this.times[p] + Math.hypot(positions[3 * i] - positions[3 * p],
        positions[3 * i + 1] - positions[3 * p + 1], positions[3 * i + 2] - positions[3 * p + 2]) / this.data.radius;
    }
    this.end = this.times.reduce((a, b) => Math.max(a, b), 0);
  }

  /** Chooses the edges of the class: those that lead to one of its stored vertices. */
  choose() {
    const { count, previous, kinds, classes } = this.paths, value = element("flightClass").value;
    const kept = new Uint8Array(count);
    for (let i = count - 1; i >= 0; --i) {
      if (value === "all" || ((kinds[i] & STORED) && classes[i] === Number(value))) kept[i] = 1;
      if (kept[i] && previous[i] >= 0) kept[previous[i]] = 1;
    }
    this.edges = [];
    this.landings = [];
    for (let i = 0; i < count; ++i) {
      if (kept[i] && previous[i] >= 0) this.edges.push(i);
      if ((kinds[i] & STORED) && (value === "all" || classes[i] === Number(value))) this.landings.push(i);
    }
    this.landings.sort((a, b) => this.times[a] - this.times[b]);
    this.makeObjects();
  }

  makeObjects() {
    const { positions, classes } = this.paths, n = this.edges.length;
    const buffer = (size) => new THREE.BufferAttribute(new Float32Array(size), 3).setUsage(THREE.DynamicDrawUsage);
    const geometry = (vertices) => {
      const g = new THREE.BufferGeometry();
      g.setAttribute("position", buffer(3 * vertices));
      g.setAttribute("color", buffer(3 * vertices));
      return g;
    };
    const palette = new Map();
    this.colour = (i) => {
      if (!palette.has(classes[i])) palette.set(classes[i], new THREE.Color(classColour(classes[i])));
      return palette.get(classes[i]);
    };
    this.trails = new THREE.LineSegments(geometry(2 * n),
      new THREE.LineBasicMaterial({ vertexColors: THREE.VertexColors, transparent: true, opacity: 0.55 }));
    this.moving = new THREE.Points(geometry(n),
      new THREE.PointsMaterial({ vertexColors: THREE.VertexColors, size: 4, sizeAttenuation: false }));
    this.landed = new THREE.Points(geometry(this.landings.length),
      new THREE.PointsMaterial({ vertexColors: THREE.VertexColors, size: 2.5, sizeAttenuation: false }));
    const { position, color } = this.landed.geometry.attributes;
    this.landings.forEach((v, i) => {
      for (let c = 0; c < 3; ++c) position.array[3 * i + c] = positions[3 * v + c];
      this.colour(v).toArray(color.array, 3 * i);
    });
    this.group = new THREE.Group();
    for (const part of [this.trails, this.moving, this.landed]) {
      part.frustumCulled = false;
      this.group.add(part);
    }
    this.isShown = false;
    element("flightStatus").textContent = `${this.paths.paths} of ${this.paths.emitted} light paths of the last pass `
      + "(limit: --shown-light-paths).";
  }

  play(on) {
    this.isPlaying = on;
    element("play").textContent = on ? "Pause" : "Play";
    if (!on) return;
    if (this.time >= this.end) this.time = 0;
    let before = null;
    const frame = (now) => {
      if (!this.isPlaying) return;
      const speed = 10 ** Number(element("flightSpeed").value); // [scene radii per second]
      // A slow frame is no jump in time.
      this.setTime(this.time + speed * Math.min(0.1, before === null ? 0 : (now - before) / 1000));
      before = now;
      if (this.time >= this.end) this.play(false);
      else requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
  }

  setTime(time) {
    this.time = Math.min(this.end, time);
    element("flightTime").value = this.end > 0 ? this.time / this.end : 0;
    this.draw();
  }

  /** Number of stored vertices that the light has reached. */
  landedCount() {
    let low = 0, high = this.landings.length;
    while (low < high) {
      const middle = low + high >> 1;
      if (this.times[this.landings[middle]] <= this.time) low = middle + 1;
      else high = middle;
    }
    return low;
  }

  draw() {
    const { positions, previous } = this.paths, { times, time } = this;
    const whole = Number(element("trail").max), value = Number(element("trail").value);
    const length = value >= whole ? Infinity : value;
    const trail = this.trails.geometry.attributes, moving = this.moving.geometry.attributes;
    let lines = 0, points = 0;
    const place = (array, at, v, t) => {
      const p = previous[v], part = times[v] > times[p] ? (t - times[p]) / (times[v] - times[p]) : 1;
      for (let c = 0; c < 3; ++c)
        array[3 * at + c] = positions[3 * p + c] + part * (positions[3 * v + c] - positions[3 * p + c]);
    };
    for (const v of this.edges) {
      const from = Math.max(times[previous[v]], time - length), to = Math.min(times[v], time);
      if (time < times[previous[v]]) continue;
      const colour = this.colour(v);
      if (from < to) {
        place(trail.position.array, 2 * lines, v, from);
        place(trail.position.array, 2 * lines + 1, v, to);
        colour.toArray(trail.color.array, 6 * lines);
        colour.toArray(trail.color.array, 6 * lines + 3);
        ++lines;
      }
      if (time >= times[v]) continue;
      place(moving.position.array, points, v, time);
      colour.toArray(moving.color.array, 3 * points);
      ++points;
    }
    const landed = this.landedCount();
    this.trails.geometry.setDrawRange(0, 2 * lines);
    this.moving.geometry.setDrawRange(0, points);
    this.landed.geometry.setDrawRange(0, landed);
    for (const attribute of [trail.position, trail.color, moving.position, moving.color]) attribute.needsUpdate = true;
    for (const part of [this.trails, this.moving, this.landed]) part.material.clippingPlanes = this.view.material.clippingPlanes;
    element("flightStatus").textContent = `${points} on their way, ${landed} of ${this.landings.length} stored`;
    Object.assign(element("view").dataset, { flying: points, landed, flightTime: time });
    if (this.isShown) this.view.draw();
    else this.show();
  }

  show() {
    this.view.replace("flight", this.group);
    this.isShown = true;
  }
}
