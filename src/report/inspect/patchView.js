// Patches of radiosity: their radiosity as colours, and form factors from a clicked patch to all others.

async function decodePatches(patches) {
  return { ...patches, positions: await decodeNumbers(patches.positions, Float32Array),
    radiosities: await decodeNumbers(patches.radiosities, Float32Array), areas: await decodeNumbers(patches.areas, Float32Array),
    sides: await decodeNumbers(patches.sides, Uint8Array), ends: await decodeNumbers(patches.ends, Uint32Array),
    columns: await decodeNumbers(patches.columns, Uint32Array), hits: await decodeNumbers(patches.hits, Uint16Array) };
}

class PatchView {
  /** Creates the view of `patches`, whose arrays are decoded. */
  constructor(view, data, patches) {
    Object.assign(this, { view, data, patches, chosen: -1 });
    this.isUsed = patches.count > 0;
    element("patchPanel").hidden = !this.isUsed;
    if (!this.isUsed) return;
    for (const name of ["showPatches", "patchLines"]) element(name).addEventListener("input", () => this.draw());
    element("patchColour").addEventListener("input", () => this.draw());
    element("patchStatus").textContent = `${patches.count} patches; ${patches.rays > 0
      ? `form factors by ${patches.rays} rays from each.` : "no form factors: they are too many for the page."}`;
    element("patchColour").disabled = patches.rays === 0;
    element("showPatches").checked = true;
    this.draw();
  }

  get isShown() { return this.isUsed && element("showPatches").checked; }

  /** Form factors from a patch to all patches. */
  factors(patch) {
    const { ends, columns, hits, rays, count } = this.patches, out = new Float64Array(count);
    for (let k = patch > 0 ? ends[patch - 1] : 0; k < ends[patch]; ++k) out[columns[k]] = hits[k] / rays;
    return out;
  }

  /** Colours of the patches, three numbers each: radiosity with the exposure of the picture, or form factors from
   * dark violet to yellow, on a scale of square roots. */
  colours() {
    const { count, radiosities } = this.patches, out = new Float32Array(3 * count);
    if (this.chosen >= 0 && element("patchColour").value === "factors") {
      const factors = this.factors(this.chosen), most = factors.reduce((a, b) => Math.max(a, b), 0) || 1, colour = new THREE.Color();
      for (let i = 0; i < count; ++i) {
        const t = Math.sqrt(factors[i] / most);
        out.set(t > 0 ? colour.setHSL(0.78 - 0.62 * t, 0.9, 0.22 + 0.4 * t).toArray() : [0.06, 0.06, 0.08], 3 * i);
      }
      out.set([1, 1, 1], 3 * this.chosen);
      return out;
    }
    const scale = 2 ** this.data.picture.exposure / Math.PI;
    for (let i = 0; i < 3 * count; ++i) out[i] = Math.min(1, radiosities[i] * scale) ** (1 / 2.2);
    return out;
  }

  draw() {
    if (!this.isUsed) return;
    this.view.surface.visible = !this.isShown;
    element("view").dataset.patches = this.isShown ? this.patches.count : 0;
    if (!this.isShown) {
      this.mesh = null;
      for (const name of ["patches", "patchLines"]) this.view.replace(name, null);
      return;
    }
    const { positions, count } = this.patches, colours = this.colours(), ofVertices = new Float32Array(9 * count);
    for (let i = 0; i < 9 * count; ++i) ofVertices[i] = colours[3 * Math.floor(i / 9) + i % 3];
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(positions, 3));
    geometry.setAttribute("color", new THREE.BufferAttribute(ofVertices, 3));
    this.mesh = new THREE.Mesh(geometry, new THREE.MeshBasicMaterial({ vertexColors: THREE.VertexColors,
      side: THREE.DoubleSide, polygonOffset: true, polygonOffsetFactor: 2, polygonOffsetUnits: 8,
      clippingPlanes: this.view.material.clippingPlanes }));
    this.view.replace("patches", this.mesh);
    this.view.replace("patchLines", element("patchLines").checked ? this.lines() : null);
  }

  lines() {
    const { positions, count } = this.patches, points = new Float32Array(18 * count);
    for (let i = 0; i < count; ++i)
      [0, 1, 1, 2, 2, 0].forEach((corner, k) => {
        for (let c = 0; c < 3; ++c) points[18 * i + 3 * k + c] = positions[9 * i + 3 * corner + c];
      });
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(points, 3));
    return new THREE.LineSegments(geometry, new THREE.LineBasicMaterial({ color: 0x000000, transparent: true, opacity: 0.35,
      clippingPlanes: this.view.material.clippingPlanes }));
  }

  /** Chooses the patch at a position of the window. */
  pick(clientX, clientY) {
    const hit = this.view.firstHit(this.mesh, clientX, clientY);
    this.choose(hit ? hit.faceIndex : -1);
  }

  choose(patch) {
    this.chosen = patch;
    element("patchChosen").hidden = patch < 0;
    if (patch >= 0) {
      if (this.patches.rays > 0) element("patchColour").value = "factors";
      this.fill(patch);
    }
    element("view").dataset.patch = patch;
    this.draw();
  }

  /** Lists the chosen patch, and the patches with the largest form factors. */
  fill(patch) {
    const MOST = 12, { areas, radiosities, rays, sides } = this.patches, factors = this.factors(patch);
    const sum = factors.reduce((a, b) => a + b, 0), error = (f) => Math.sqrt(f * (1 - f) / rays);
    const colour = (i) => [...radiosities.slice(3 * i, 3 * i + 3)].map(numberText).join(" ");
    const rows = [["patch", `${patch}, ${sides[patch] ? "inner" : "outer"} side`], ["area", numberText(areas[patch])],
      ["radiosity", colour(patch)]];
    if (rays > 0)
      rows.push(["sum of form factors", `${sum.toFixed(3)} ± ${error(Math.min(1, sum)).toFixed(3)}`],
        ["to the open, or to what is not divided", (1 - sum).toFixed(3)]);
    element("patchText").replaceChildren(...rows.flatMap(([name, text]) => {
      const dt = document.createElement("dt"), dd = document.createElement("dd");
      dt.textContent = name;
      dd.textContent = text;
      return [dt, dd];
    }));
    const table = element("factors"), order = [...factors.keys()].filter((i) => factors[i] > 0)
      .sort((a, b) => factors[b] - factors[a]).slice(0, MOST);
    table.replaceChildren();
    if (rays === 0) return;
    addRow(table, ["patch", "form factor", "error", "area", "radiosity"], "th");
    for (const i of order)
      addRow(table, [i, factors[i].toFixed(4), error(factors[i]).toFixed(4), numberText(areas[i]), colour(i)])
        .addEventListener("click", () => this.choose(i));
  }
}
