// Photons of the map: points in the scene, and the density estimate at a clicked point, computed here.

const CAUSTIC = 128;

/** Irradiance and its standard error, by an Epanechnikov kernel of `radius`. `found`: photons, the nearest first. */
function irradiance(found, powers, radius) {
  const sum = [0, 0, 0], r2 = radius * radius;
  let squares = 0, count = 0;
  for (const { index, distance2 } of found) {
    if (distance2 >= r2) break;
    const weight = 2 / (Math.PI * r2) * (1 - distance2 / r2);
    for (let c = 0; c < 3; ++c) sum[c] += weight * powers[3 * index + c];
    squares += (weight * luminance(powers[3 * index], powers[3 * index + 1], powers[3 * index + 2])) ** 2;
    ++count;
  }
  return { value: sum, count, error: Math.sqrt(squares) };
}

class PhotonView {
  /** Creates the view of `photons`, whose arrays are decoded. */
  constructor(view, data, photons) {
    Object.assign(this, { view, data, photons });
    const { count, inMap } = photons;
    element("photonCount").textContent = inMap === 0 ? "The integrator stores no photons; use photonmap."
      : count === inMap ? `All ${count} photons of the integrator's last map.`
        : `${count} of ${inMap} photons of the integrator's last map, each represents ${Math.round(inMap / count)}.`;
    element("photonTools").hidden = count === 0;
    for (const name of ["showPhotons", "photonColour", "photonSize"])
      element(name).addEventListener("input", () => this.draw());
    element("radius").addEventListener("input", () => this.setRadius(this.radiusAt(Number(element("radius").value))));
    element("number").addEventListener("input", () => this.setNumber(this.numberAt(Number(element("number").value))));
  }

  colourOf(i, mode, brightest) {
    const kind = this.photons.kinds[i];
    if (mode === "class") return new THREE.Color(classColour(kind & ~CAUSTIC));
    if (mode === "map") return new THREE.Color(kind & CAUSTIC ? "#ffd166" : "#4fa3ff");
    const { powers } = this.photons, y = luminance(powers[3 * i], powers[3 * i + 1], powers[3 * i + 2]) / brightest;
    return new THREE.Color().setHSL(0.66 * (1 - Math.min(1, Math.sqrt(y))), 1, 0.55);
  }

  draw() {
    const { count, positions } = this.photons;
    if (!element("showPhotons").checked || count === 0) {
      this.view.replace("photons", null);
      return;
    }
    const mode = element("photonColour").value, colours = new Float32Array(3 * count);
    const brightest = mode === "power" ? this.brightPower() : 1;
    for (let i = 0; i < count; ++i) this.colourOf(i, mode, brightest).toArray(colours, 3 * i);
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(positions, 3));
    geometry.setAttribute("color", new THREE.BufferAttribute(colours, 3));
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

  /** Collects the photons on the side of a surface that was clicked. */
  pick({ point, normal, name }) {
    const { count, positions, normals } = this.photons;
    if (count === 0) return;
    const MOST = 5000, FLAT = 0.15, farthest = 0.25 * this.data.radius;
    const found = [];
    for (let i = 0; i < count; ++i) {
      const x = positions[3 * i] - point.x, y = positions[3 * i + 1] - point.y, z = positions[3 * i + 2] - point.z;
      const distance2 = x * x + y * y + z * z;
      if (distance2 > farthest * farthest) continue;
      const side = (normals[3 * i] * normal.x + normals[3 * i + 1] * normal.y + normals[3 * i + 2] * normal.z) / 127;
      const height = x * normal.x + y * normal.y + z * normal.z;
      if (side > 0.5 && height * height <= FLAT * FLAT * distance2 + 1e-8 * farthest * farthest)
        found.push({ index: i, distance2 });
    }
    found.sort((a, b) => a.distance2 - b.distance2);
    this.found = found.slice(0, MOST);
    Object.assign(this, { point, normal, name });
    element("estimate").hidden = false;
    const last = this.found.at(-1);
    this.limits = [Math.sqrt(this.found[Math.min(3, this.found.length - 1)]?.distance2 ?? 1e-4 * farthest ** 2) * 1.01,
      Math.sqrt(last?.distance2 ?? farthest * farthest) * 1.001];
    this.setNumber(Math.min(100, this.found.length));
  }

  radiusAt(slider) { return this.limits[0] * (this.limits[1] / this.limits[0]) ** slider; }
  numberAt(slider) { return Math.max(1, Math.round(this.found.length ** slider)); }

  setNumber(number) {
    const at = this.found[Math.max(0, Math.min(number, this.found.length) - 1)];
    this.setRadius(at ? Math.sqrt(at.distance2) * (1 + 1e-6) : this.limits[1]);
  }

  setRadius(radius) {
    this.radius = radius;
    const { value, count, error } = irradiance(this.found, this.photons.powers, radius), y = luminance(...value);
    element("radius").value = Math.log(radius / this.limits[0]) / Math.log(this.limits[1] / this.limits[0]);
    element("radiusText").textContent = numberText(radius);
    element("number").value = count > 0 ? Math.log(count) / Math.log(Math.max(2, this.found.length)) : 0;
    element("numberText").textContent = count;
    const rows = [["surface", this.name],
      ["position", worldText(this.data, this.point.toArray())],
      ["irradiance, red green blue", value.map(numberText).join("  ")],
      ["luminance", `${numberText(y)} ± ${numberText(error)}`],
      ["noise", y > 0 ? `${(100 * error / y).toFixed(0)} %` : "–"]];
    element("estimateText").replaceChildren(...rows.flatMap(([name, text]) => {
      const dt = document.createElement("dt"), dd = document.createElement("dd");
      dt.textContent = name;
      dd.textContent = text;
      return [dt, dd];
    }));
    this.drawCurve();
    this.drawSupport(count);
  }

  /** Draws irradiance against radius, with a band of one standard error on both sides. */
  drawCurve() {
    const canvas = element("curve"), context = canvas.getContext("2d"), { width, height } = canvas, STEPS = 80;
    const points = Array.from({ length: STEPS + 1 }, (_, i) => {
      const radius = this.radiusAt(i / STEPS), e = irradiance(this.found, this.photons.powers, radius);
      return { x: i / STEPS, y: luminance(...e.value), error: e.error };
    });
    const top = 1.1 * Math.max(1e-30, ...points.slice(STEPS / 4).map((p) => p.y + p.error));
    const place = (x, y) => [6 + x * (width - 12), height - 6 - Math.min(1.05, Math.max(0, y / top)) * (height - 12)];
    context.clearRect(0, 0, width, height);
    context.beginPath();
    for (const p of points) context.lineTo(...place(p.x, p.y + p.error));
    for (const p of [...points].reverse()) context.lineTo(...place(p.x, p.y - p.error));
    context.fillStyle = "#4fa3ff55";
    context.fill();
    context.beginPath();
    for (const p of points) context.lineTo(...place(p.x, p.y));
    context.strokeStyle = "#4fa3ff";
    context.lineWidth = 2;
    context.stroke();
    const now = Number(element("radius").value);
    context.beginPath();
    context.moveTo(...place(now, 0));
    context.lineTo(...place(now, top));
    context.strokeStyle = "#f0b45a";
    context.stroke();
  }

  /** Draws the support, its photons, and the directions that they came from. */
  drawSupport(count) {
    const { positions, directions } = this.photons, group = new THREE.Group(), dots = [], lines = [];
    for (const { index } of this.found.slice(0, Math.min(count, 1000))) {
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
