// Recorded paths of a pixel: drawn in the scene, listed, and filtered by class and expression. inspectPage.cpp defines
// the columns of the lists in the page's data.

const CLASS_COLOURS = ["#ffd166", "#4fa3ff", "#ff6b6b", "#5fd38d", "#c792ea", "#ff9f43", "#54d6d6", "#e75fa9", "#a3c644",
  "#8f9bff", "#d9a066", "#66bb6a", "#b0bec5", "#ef5da8", "#7fdbff", "#c0ca33"];
const NO_CLASS = 127, UNCLASSIFIED = 126; // the latter: the page works the class out
const classColour = (i) => i === NO_CLASS ? "#9aa2b1" : CLASS_COLOURS[i % CLASS_COLOURS.length];

/** Possible events of photons before they are merged: all sequences of up to four. */
const PREFIXES = (() => {
  const all = [[]];
  for (let i = 0; all[i].length < 4; ++i) for (const letter of "SD") all.push([...all[i], { letter, names: null }]);
  return all;
})();

/** Letter that stands for events that are not known. */
const UNKNOWN = { letter: "…", names: null };

/** Paths of one pixel, as objects made from the lists of the page. */
class PixelPaths {
  /** `classes`: with their expressions compiled. */
  constructor(pixel, data, classes) {
    Object.assign(this, { pixel, names: data.names, lamps: data.lamps, classes });
    this.paths = pixel.contributions.map((c, i) => this.path(c, i));
    this.paths.sort((a, b) => b.brightness - a.brightness);
  }

  path([technique, vertex, step, estimate, end, isInfinite, weight, pdf, otherPdf, cls, radiance, lightVertex, densities,
    weights, omission, panes, lamp], i) {
    const sample = this.pixel.samples.findIndex(([first, last]) => i >= first && i < last);
    const found = { technique: this.names[technique], end, isInfinite, weight, pdf, otherPdf, cls, radiance, sample,
      densities, panes, omission: this.names[omission], estimate: this.pixel.estimates[estimate],
      weights: weights.map(([name, vertices, w]) => [this.names[name], vertices, w]) };
    found.byRay = found.technique === "hit" || found.technique === "emission along a ray";
    const last = found.byRay || vertex < 0 ? (this.pixel.steps[step]?.[0] ?? -1) : vertex;
    found.steps = this.stepsTo(found.byRay ? step : this.pixel.vertices[last]?.[0] ?? -1);
    found.vertices = this.verticesTo(last);
    found.lightVertices = this.lightVerticesFrom(lightVertex);
    found.letters = this.lettersOf(found, lamp);
    found.word = found.letters.map((l) => l.letter).join("");
    found.brightness = luminance(...radiance) / this.pixel.samples.length;
    if (cls === UNCLASSIFIED) found.cls = this.classOf(found);
    return found;
  }

  /** Steps from the camera up to a step. */
  stepsTo(step) {
    const out = [];
    for (; step >= 0; step = this.pixel.vertices[this.pixel.steps[step][0]][0]) out.unshift(this.pixel.steps[step]);
    return out;
  }

  verticesTo(vertex) {
    const out = [];
    while (vertex >= 0) {
      out.unshift(this.pixel.vertices[vertex]);
      const step = this.pixel.vertices[vertex][0];
      vertex = step < 0 ? -1 : this.pixel.steps[step][0];
    }
    return out;
  }

  /** Vertices of the light path, from a vertex to the light: [previous, event at the previous vertex, position, flux,
   *  object, material, non-delta lobes; of the event at the previous vertex: lobe, pdf, reverse pdf; names of the
   *  surface]. */
  lightVerticesFrom(vertex) {
    const out = [];
    for (; vertex >= 0; vertex = this.pixel.lightVertices[vertex][0]) out.push(this.pixel.lightVertices[vertex]);
    return out;
  }

  /** Word of a path: L, the events from the light on, E, with the names of lights and surfaces as far as they are
   * known. An unknown number of events of photons is one letter. */
  lettersOf({ technique, byRay, panes, steps, vertices, lightVertices }, lamp) {
    const named = (names) => names?.map((name) => this.names[name]) ?? null;
    // The event of a vertex next to the light is that of the start, which is none.
    const light = lightVertices.slice(0, -2).map((v, k) => ({ letter: v[1], names: named(lightVertices[k + 1][10]) })).reverse();
    const events = steps.map((s) => ({ letter: s[1], names: named(this.pixel.vertices[s[0]]?.[8]) })).reverse();
    const last = vertices.at(-1), at = { letter: last?.[5] ? "V" : "D", names: named(last?.[8]) };
    const L = { letter: "L", names: lamp >= 0 ? [this.lamps[lamp]] : null }, E = { letter: "E", names: null };
    const pane = { letter: "S", names: null };
    if (byRay) return [L, ...events, E];
    if (technique === "light sample") return [L, ...Array(panes).fill(pane), at, ...events, E];
    if (["merge", "patches", "ambient term"].includes(technique))
      return [L, ...(lightVertices.length > 0 ? light : [UNKNOWN]), at, ...events, E];
    if (technique === "connection") return [L, ...light, { letter: "D", names: named(lightVertices[0]?.[10]) }, at, ...events, E];
    return [L, UNKNOWN, ...events, E];
  }

  /** All words that a path may have. */
  wordsOf(path) {
    const at = path.letters.indexOf(UNKNOWN);
    if (at < 0) return [path.letters];
    return PREFIXES.map((events) => [...path.letters.slice(0, at), ...events, ...path.letters.slice(at + 1)]);
  }

  /** Whether an expression may contain a path: a word of its class. */
  matches(path, expression) {
    const own = this.classes[path.cls]?.compiled, words = this.wordsOf(path);
    return words.some((word) => expression.contains(word) && (words.length === 1 || !own || own.contains(word)));
  }

  /** The class of all words that a path may have; NO_CLASS if they have several. */
  classOf(path) {
    const all = new Set(this.wordsOf(path).map((word) => this.classes.findIndex((c) => c.compiled?.contains(word))));
    const [first] = all;
    return all.size === 1 && first >= 0 ? first : NO_CLASS;
  }
}

class PathView {
  constructor(view, data) {
    this.view = view;
    this.data = data;
    this.hidden = new Set();
    this.known = { lights: data.lightNames, surfaces: data.surfaceNames, classes: data.namedClasses };
    this.classes = data.classes.map((c) => ({ ...c, compiled: this.compiled(c.expression).expression }));
    element("showPaths").addEventListener("input", () => this.draw());
    element("sample").addEventListener("input", () => this.update());
    element("filter").addEventListener("input", () => this.update());
    element("recordNotes").textContent = data.notes.join(" ");
    element("recordNotes").hidden = data.notes.length === 0;
  }

  show(pixel) {
    this.pixel = pixel;
    this.paths = new PixelPaths(pixel, this.data, this.classes);
    this.chosen = null;
    element("pixelName").textContent = `${pixel.x}, ${pixel.y}`;
    const options = ["all", ...pixel.samples.keys()].map((name) => new Option(name, name));
    element("sample").replaceChildren(...options);
    this.listClasses();
    this.update();
  }

  listClasses() {
    const parts = new Map();
    let sum = 0;
    for (const path of this.paths.paths) {
      parts.set(path.cls, (parts.get(path.cls) ?? 0) + path.brightness);
      sum += path.brightness;
    }
    element("classes").replaceChildren(...[...parts].sort((a, b) => b[1] - a[1]).map(([cls, part]) => {
      const item = document.createElement("li"), label = document.createElement("label");
      const box = document.createElement("input"), text = document.createElement("span");
      box.type = "checkbox";
      box.checked = !this.hidden.has(cls);
      box.addEventListener("input", () => {
        this.hidden[box.checked ? "delete" : "add"](cls);
        this.update();
      });
      text.textContent = this.data.classes[cls]?.name ?? "other";
      text.title = this.data.classes[cls]?.expression ?? "";
      const share = document.createElement("span");
      share.className = "part";
      share.textContent = sum > 0 ? `${(100 * part / sum).toFixed(1)} %` : "";
      label.append(box, swatch(classColour(cls)), text, share);
      item.append(label);
      return item;
    }));
  }

  /** An expression { expression }, or the reason why there is none { reason }. */
  compiled(text) {
    try {
      return { expression: new PathExpression(text, this.known) };
    } catch (error) {
      if (!(error instanceof ExpressionError)) throw error;
      return { expression: null, reason: error.message };
    }
  }

  /** Paths that pass the filters, the brightest first. */
  shown() {
    const text = element("filter").value, isEmpty = text.trim() === "";
    let { expression, reason } = isEmpty ? { expression: null } : this.compiled(text);
    const namesLight = /L\s*'/.test(text);
    if (expression && namesLight && this.data.lamps.length === 0) {
      expression = null;
      reason = "this page does not know which light a path came from";
    }
    element("filter").classList.toggle("bad", !!reason);
    element("filterReason").textContent = reason ? `Not filtered: ${reason}` : "";
    element("filterReason").hidden = !reason;
    const sample = element("sample").value;
    return this.paths.paths.filter((path) => !this.hidden.has(path.cls)
      && (sample === "all" || path.sample === Number(sample)) && (!expression || this.paths.matches(path, expression)));
  }

  update() {
    if (!this.pixel) return;
    this.list = this.shown();
    if (!this.list.includes(this.chosen)) this.chosen = null;
    const sum = this.list.reduce((s, path) => s + path.brightness, 0), all = luminance(...this.pixel.value);
    const splats = luminance(...this.pixel.splats);
    element("pathStatus").textContent = `${this.list.length} of ${this.paths.paths.length} contributions of `
      + `${this.pixel.samples.length} samples: ${formatValue(sum)} of the pixel's ${formatValue(all)} in luminance`
      + (splats > 0 ? `; connections to the camera, without a record, add ${formatValue(splats)}` : "");
    this.fillContributions();
    this.draw();
  }

  fillContributions() {
    const MOST = 200, table = element("contributions");
    table.replaceChildren();
    addRow(table, ["class", "path", "technique", "sample", "weight", "light"], "th");
    for (const path of this.list.slice(0, MOST)) {
      const name = document.createElement("span");
      name.append(swatch(classColour(path.cls)), ` ${this.data.classes[path.cls]?.name ?? "other"}`);
      const row = addRow(table, [name, path.word, path.technique, path.sample, numberText(path.weight),
        numberText(path.brightness)]);
      row.addEventListener("click", () => this.choose(path === this.chosen ? null : path));
      row.path = path;
    }
    this.markChosen();
  }

  choose(path) {
    this.chosen = path;
    this.markChosen();
    this.draw();
  }

  markChosen() {
    for (const row of element("contributions").rows) row.classList.toggle("chosen", !!row.path && row.path === this.chosen);
    element("chosen").hidden = !this.chosen;
    if (this.chosen) this.fillVertices(this.chosen);
  }

  /** Fills one row for each vertex from the camera on, and one for the end at the light or the photons. A vertex has
   *  the lobe and the densities of the event there: where paths are joined, of the direction to the other side. */
  fillVertices(path) {
    const table = element("vertices"), sample = this.pixel.samples[path.sample];
    const world = (p) => worldText(this.data, p), colour = (c) => c.map(numberText).join(" ");
    const density = (x) => x > 0 ? numberText(x) : "";
    element("word").textContent = path.word;
    table.replaceChildren();
    addRow(table, ["", "object", "material", "lobe", "throughput", "pdf", "reverse pdf", "position"], "th");
    addRow(table, ["E", "camera", "", "", "1", "", "", world(sample[2])]);
    path.vertices.forEach((v, i) => {
      const step = path.steps[i];
      const letter = step ? step[1] : v[5] ? "V" : "D", [pdf, reverse] = step ? step.slice(3, 5) : path.densities;
      addRow(table, [letter, this.data.names[v[3]], this.data.names[v[4]], this.data.names[step ? step[2] : v[7]],
        colour(v[6]), density(pdf), density(reverse), world(v[1])]);
    });
    if (path.lightVertices.length > 0) this.fillLightPath(path, table);
    else this.fillEnd(path, table);
    element("pathWeights").textContent = weightsText(path);
    element("omission").textContent = path.omission ? `The path to the light is not known: ${path.omission}.` : "";
  }

  /** Fills one row for the edge that joins both sides, and one for each vertex of the light path, with its densities from
   *  the light on. */
  fillLightPath(path, table) {
    const colour = (c) => c.map(numberText).join(" "), density = (x) => x > 0 ? numberText(x) : "";
    const names = this.data.names, isConnection = path.technique === "connection";
    addRow(table, ["", "light path", path.technique, `weight ${numberText(path.weight)}`, colour(path.radiance), "", "", ""]);
    path.lightVertices.forEach(([previous, , position, flux, object, material, lobes], i) => {
      const next = path.lightVertices[i - 1];
      const [letter, lobe, pdf, reverse] = next ? [next[1], names[next[7]], next[8], next[9]]
        : isConnection ? ["D", names[lobes], path.densities[2], path.densities[3]] : ["", "", 0, 0];
      addRow(table, [previous < 0 ? "L" : letter, names[object], names[material], lobe, colour(flux), density(pdf),
        density(reverse), worldText(this.data, position)]);
    });
  }

  /** Fills the row of the light or the photons at the end of a path without a light path. */
  fillEnd(path, table) {
    const world = (p) => worldText(this.data, p), colour = (c) => c.map(numberText).join(" ");
    const e = path.estimate;
    const through = path.panes > 0 ? ` through ${path.panes} ${path.panes > 1 ? "panes" : "pane"}` : "";
    const what = e ? `${e[3]} photons within ${numberText(e[2])}` : path.technique + through;
    const towards = () => [path.end[0] * this.data.mirror, path.end[1], path.end[2]].map(numberText).join(" ");
    const isPoint = !path.omission || path.technique === "merge" && !e;
    const place = !isPoint ? "" : path.isInfinite ? `towards ${towards()}` : world(path.end);
    addRow(table, ["L", what, "", `weight ${numberText(path.weight)}`, colour(path.radiance),
      path.pdf > 0 ? numberText(path.pdf) : "", path.otherPdf > 0 ? `other ${numberText(path.otherPdf)}` : "", place]);
  }

  /** Points of a path from the camera on. */
  pointsOf(path) {
    const sample = this.pixel.samples[path.sample], points = [vector(sample[2])];
    for (const v of path.vertices) points.push(vector(v[1]));
    if (path.isInfinite) points.push(points.at(-1).clone().addScaledVector(vector(path.end), this.data.radius));
    else if (path.byRay || path.technique === "light sample") points.push(vector(path.end));
    for (const v of path.lightVertices) points.push(vector(v[2]));
    return points;
  }

  draw() {
    const group = new THREE.Group(), R = this.scale(), segments = [], first = [];
    const paths = !this.pixel || !element("showPaths").checked ? [] : this.chosen ? [this.chosen] : this.list;
    const brightest = Math.max(1e-30, ...paths.map((path) => path.brightness));
    for (const path of paths) {
      const colour = new THREE.Color(classColour(path.cls)), points = this.pointsOf(path);
      const radius = R * (0.0006 + 0.004 * Math.sqrt(path.brightness / brightest));
      // The light's side is thinner, and the edge that joins both sides is thinnest.
      const join = 1 + path.vertices.length, hasLightPath = path.lightVertices.length > 0;
      const width = (i) => !hasLightPath || i < join ? radius : i === join ? 0.35 * radius : 0.6 * radius;
      for (let i = 1; i < points.length; ++i)
        (i === 1 ? first : segments).push([points[i - 1], points[i], width(i), colour, i === 1]);
      if (path.estimate) group.add(this.ring(path, colour));
    }
    const addTubes = (list, to) => {
      if (list.length === 0) return;
      const geometry = tubes(list);
      const mesh = (more) => new THREE.Mesh(geometry, new THREE.MeshBasicMaterial({ vertexColors: THREE.VertexColors, ...more }));
      // Parts behind walls are drawn translucent.
      to.add(mesh({}), mesh({ depthTest: false, transparent: true, opacity: 0.3 }));
    };
    const fromEye = new THREE.Group();
    addTubes(segments, group);
    addTubes(first, fromEye);
    group.add(fromEye);
    if (paths.length > 0) group.add(this.dots(paths));
    this.view.fromEye = fromEye; // hidden where the view is from the camera
    element("view").dataset.segments = segments.length + first.length;
    this.view.replace("paths", group);
  }

  /** Length that widths are in proportion to: the scene's radius, or the length of camera rays if they are shorter. */
  scale() {
    const lengths = (this.pixel?.samples ?? []).map((sample) => {
      const first = this.paths.paths.find((path) => this.pixel.samples[path.sample] === sample && path.vertices.length > 0);
      return first ? vector(sample[2]).distanceTo(vector(first.vertices[0][1])) : Infinity;
    });
    return Math.min(this.data.radius, ...lengths.filter((x) => x > 0));
  }

  /** Circle around the support of a density estimate. */
  ring(path, colour) {
    const [, position, normal] = path.vertices.at(-1), points = [];
    const frame = new THREE.Quaternion().setFromUnitVectors(new THREE.Vector3(0, 0, 1), vector(normal));
    for (let i = 0; i <= 48; ++i) {
      const a = 2 * Math.PI * i / 48;
      points.push(new THREE.Vector3(Math.cos(a), Math.sin(a), 0).multiplyScalar(path.estimate[2])
        .applyQuaternion(frame).add(vector(position)).addScaledVector(vector(normal), 0.002 * this.data.radius));
    }
    return new THREE.Line(new THREE.BufferGeometry().setFromPoints(points), new THREE.LineBasicMaterial({ color: colour }));
  }

  dots(paths) {
    const points = paths.flatMap((path) => this.pointsOf(path).slice(1));
    return new THREE.Points(new THREE.BufferGeometry().setFromPoints(points),
      new THREE.PointsMaterial({ color: 0xffffff, size: 4, sizeAttenuation: false }));
  }
}

/** MIS weights of the techniques that can make a path, in words. */
function weightsText({ technique, weight, pdf, otherPdf, weights }) {
  const after = (name, n) => name === "connection" || name === "merge" ? `${name} after ${n} from the camera` : name;
  if (weights.length > 0)
    return `Weights of all techniques: ${weights.map(([name, n, w]) => `${after(name, n)} ${numberText(w)}`).join(" · ")}`;
  if (!(pdf > 0 && otherPdf > 0)) return "";
  // Without a third technique, the power heuristic of both densities.
  const isPair = Math.abs(weight - pdf * pdf / (pdf * pdf + otherPdf * otherPdf)) < 1e-3;
  const other = !isPair ? "others" : technique === "hit" ? "light sample" : "hit";
  return `Weights of all techniques: ${technique} ${numberText(weight)} · ${other} ${numberText(1 - weight)}`;
}

function swatch(colour) {
  const out = document.createElement("span");
  out.className = "swatch";
  out.style.background = colour;
  return out;
}

function addRow(table, cells, tag = "td") {
  const row = table.insertRow();
  cells.forEach((content, i) => {
    const cell = document.createElement(tag);
    cell.append(content);
    if (i < 3) cell.className = "left";
    row.append(cell);
  });
  return row;
}

/** Point of the view, as text in the coordinates of the scene file. */
function worldText(data, p) {
  return p.map((x, k) => numberText((k === 0 ? data.mirror * x : x) + data.origin[k])).join(" ");
}

/** Number with three significant digits. */
function numberText(x) {
  if (x === null || x === undefined || !Number.isFinite(x)) return "–";
  if (x === 0) return "0";
  return Math.abs(x) < 1e-3 || Math.abs(x) >= 1e5 ? x.toExponential(2) : String(Number(x.toPrecision(3)));
}
