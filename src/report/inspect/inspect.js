// Page of the light in a scene: connects the scene, the paths of pixels and the photons.

async function decodeMesh(mesh) {
  return { ...mesh, positions: await decodeNumbers(mesh.positions, Float32Array),
    colours: await decodeNumbers(mesh.colours, Uint8Array), objects: await decodeNumbers(mesh.objects, Uint16Array),
    specular: await decodeNumbers(mesh.specular, Uint8Array) };
}

async function decodePhotons(photons) {
  return { ...photons, positions: await decodeNumbers(photons.positions, Float32Array),
    powers: await decodeNumbers(photons.powers, Float32Array), normals: await decodeNumbers(photons.normals, Int8Array),
    directions: await decodeNumbers(photons.directions, Int8Array), kinds: await decodeNumbers(photons.kinds, Uint8Array),
    depths: await decodeNumbers(photons.depths, Uint8Array) };
}

async function decodeLightPaths(paths) {
  return { ...paths, positions: await decodeNumbers(paths.positions, Float32Array),
    powers: await decodeNumbers(paths.powers, Float32Array), previous: await decodeNumbers(paths.previous, Int32Array),
    kinds: await decodeNumbers(paths.kinds, Uint8Array), classes: await decodeNumbers(paths.classes, Uint8Array) };
}

async function decodeBoxes(boxes) {
  return { ...boxes, bounds: await decodeNumbers(boxes.bounds, Float32Array), levels: await decodeNumbers(boxes.levels, Uint8Array),
    caustic: await decodeNumbers(boxes.caustic, Uint8Array), photons: await decodeNumbers(boxes.photons, Uint32Array) };
}

/** Whether the scene's axes are left-handed, as in pbrt files; WebGL's are right-handed. */
function isLeftHanded(rays) {
  if (rays.some((ray) => !ray)) return true;
  const corner = (i) => vector(rays[i].origin).add(vector(rays[i].direction));
  const right = corner(1).sub(corner(0)), up = corner(0).sub(corner(3));
  return right.cross(up).dot(vector(rays[4].direction)) > 0;
}

/** Negates x in all data of the page if the axes are left-handed. `data.mirror`: factor that restores x. */
function mirror(data, { mesh, photons, lightPaths, boxes, patches }) {
  data.mirror = isLeftHanded(data.camera) ? -1 : 1;
  if (data.mirror > 0) return;
  const turn = (v) => { v[0] = -v[0]; };
  const turnAll = (array) => { for (let i = 0; i < array.length; i += 3) array[i] = -array[i]; };
  turn(data.center);
  for (const ray of data.camera) if (ray) [ray.origin, ray.direction].forEach(turn);
  for (const box of data.media) box.forEach(turn);
  for (const array of [mesh.positions, photons.positions, photons.normals, photons.directions, lightPaths.positions,
    boxes.bounds, patches.positions]) turnAll(array);
  for (const reference of data.references) [reference.position, reference.normal].forEach(turn);
  for (const { samples, vertices, steps, contributions, lightVertices } of data.pixels) {
    for (const vertex of lightVertices) turn(vertex[2]);
    for (const sample of samples) [sample[2], sample[3]].forEach(turn);
    for (const vertex of vertices) [vertex[1], vertex[2]].forEach(turn);
    for (const step of steps) turn(step[6]);
    for (const contribution of contributions) turn(contribution[4]);
  }
}

/** Picture with a mark on each recorded pixel. */
class Picture {
  constructor(data, values, choose) {
    this.data = data;
    const { width, height, exposure } = data.picture;
    this.plain = document.createElement("canvas");
    paint(this.plain, values, width, height, exposure);
    this.scale = Math.max(1, Math.round(640 / width));
    Object.assign(element("picture"), { width: width * this.scale, height: height * this.scale });
    element("picture").addEventListener("click", (event) => {
      const pixel = this.nearest(event);
      if (pixel) choose(pixel);
    });
    this.draw(null);
  }

  /** Centre of a pixel on the canvas. */
  place(pixel) {
    return [pixel.x - this.data.picture.x0 + 0.5, pixel.y - this.data.picture.y0 + 0.5].map((x) => x * this.scale);
  }

  nearest(event) {
    const canvas = element("picture"), box = canvas.getBoundingClientRect();
    const zoom = Math.min(box.width / canvas.width, box.height / canvas.height);
    const x = (event.clientX - box.left - (box.width - canvas.width * zoom) / 2) / zoom;
    const y = (event.clientY - box.top - (box.height - canvas.height * zoom) / 2) / zoom;
    const away = (pixel) => Math.hypot(this.place(pixel)[0] - x, this.place(pixel)[1] - y);
    return [...this.data.pixels].sort((a, b) => away(a) - away(b))[0];
  }

  draw(chosen, marks = true) {
    const canvas = element("picture"), context = canvas.getContext("2d");
    context.imageSmoothingEnabled = false;
    context.drawImage(this.plain, 0, 0, canvas.width, canvas.height);
    if (!marks) return;
    for (const pixel of this.data.pixels) {
      const [x, y] = this.place(pixel), size = pixel === chosen ? 9 : 5;
      for (const [style, width] of [["#000", 7], [pixel === chosen ? "#f0b45a" : "#fff", 3]]) {
        context.strokeStyle = style;
        context.lineWidth = width;
        context.strokeRect(x - size, y - size, 2 * size, 2 * size);
      }
    }
  }
}

/** Calls act(event) for clicks that are not drags. */
function onClick(canvas, act) {
  let down = null;
  canvas.addEventListener("pointerdown", (event) => { down = [event.clientX, event.clientY]; });
  canvas.addEventListener("pointerup", (event) => {
    const moved = down ? Math.hypot(event.clientX - down[0], event.clientY - down[1]) : Infinity;
    down = null;
    if (moved < 4 && event.button === 0) act(event);
  });
}

function connect(data, view, photonView, patchView, others) {
  element("wire").addEventListener("input", () => view.setWireFrame(element("wire").checked));
  element("opacity").addEventListener("input", () => view.setOpacity(Number(element("opacity").value)));
  const cut = () => {
    view.cut(element("cutAxis").value, Number(element("cut").value), element("cutTurned").checked);
    photonView.draw();
    for (const other of others) other.draw();
  };
  for (const name of ["cutAxis", "cut", "cutTurned"]) element(name).addEventListener("input", cut);
  for (const button of document.querySelectorAll("#views button"))
    button.addEventListener("click", () => {
      // Views along an axis cut away the near half of a room.
      const { axis, isTurned } = view.look(button.dataset.view);
      element("cutAxis").value = axis;
      element("cut").value = 0;
      element("cutTurned").checked = isTurned;
      cut();
    });
  onClick(element("view"), (event) => {
    if (patchView.isShown) {
      patchView.pick(event.clientX, event.clientY);
      return;
    }
    const hit = view.pick(event.clientX, event.clientY);
    element("where").textContent = hit
      ? `${hit.name}: ${worldText(data, hit.point.toArray())}` : "";
    if (hit) photonView.pick(photonView.nearReference(hit) ?? hit);
  });
}

function remarks(data, mesh) {
  const texts = [];
  if (mesh.triangles < mesh.before) texts.push(`Simplified: ${mesh.triangles} of ${mesh.before} triangles.`);
  const { sampledShapes, curves, shownCurves } = mesh;
  if (sampledShapes > 0)
    texts.push(`Approximated by a grid: ${sampledShapes} ${sampledShapes === 1 ? "shape" : "shapes"} without faces.`);
  if (shownCurves < curves) texts.push(`Shown: ${shownCurves} of ${curves} segments of curves, wider.`);
  element("simplified").hidden = texts.length === 0;
  element("simplified").textContent = texts.join(" ");
}

async function start() {
  const data = JSON.parse(element("data").textContent);
  element("title").textContent = data.title;
  element("label").textContent = data.label;
  const values = await decodeLayer(data.picture, data.picture.width * data.picture.height);
  const mesh = await decodeMesh(data.mesh), photons = await decodePhotons(data.photons);
  const lightPaths = await decodeLightPaths(data.lightPaths), boxes = await decodeBoxes(data.boxes);
  const patches = await decodePatches(data.patches);
  mirror(data, { mesh, photons, lightPaths, boxes, patches });
  let paths = null, photonView = null;
  const choose = (pixel) => {
    paths.show(pixel);
    picture.draw(pixel);
    photonView.offerReference(pixel);
  };
  frame(data, mesh);
  const picture = new Picture(data, values, choose);
  picture.draw(null, false); // no marks in the picture of the frustum
  const view = new SceneView(data, mesh);
  view.renderer.render(view.scene, view.camera);
  paths = new PathView(view, data);
  photonView = new PhotonView(view, data, photons);
  const patchView = new PatchView(view, data, patches);
  connect(data, view, photonView, patchView,
    [new FlightView(view, data, lightPaths), new BoxView(view, boxes), patchView].filter((other) => other.isUsed));
  remarks(data, mesh);
  picture.draw(null);
  if (data.pixels.length > 0) choose(data.pixels[Math.floor(data.pixels.length / 2)]);
  document.body.dataset.ready = "yes";
}

start().catch((error) => {
  element("failure").hidden = false;
  element("failure").textContent = `The page cannot be shown: ${error.message ?? error}`;
  throw error;
});
