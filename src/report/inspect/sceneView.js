// Scene in 3D: triangles, the camera with its picture, views, wire frame, and a cutting plane.

const element = (id) => document.getElementById(id);
const AXES = ["x", "y", "z"];
const vector = (v) => new THREE.Vector3(v[0], v[1], v[2]);

/** Prisms along segments [from, to, radius, colour, isPointed], as one mesh, since WebGL's lines are one pixel wide. A
 * pointed prism has no width at its start. */
function tubes(segments) {
  const SIDES = 5, positions = [], normals = [], colours = [];
  const along = new THREE.Vector3(), across = new THREE.Vector3(), other = new THREE.Vector3();
  for (const [from, to, radius, colour, isPointed] of segments) {
    along.subVectors(to, from);
    if (!(along.lengthSq() > 0)) continue;
    along.normalize();
    across.set(Math.abs(along.x) < 0.5 ? 1 : 0, Math.abs(along.x) < 0.5 ? 0 : 1, 0).cross(along).normalize();
    other.crossVectors(along, across);
    const corner = (k) => {
      const a = 2 * Math.PI * k / SIDES;
      return across.clone().multiplyScalar(Math.cos(a)).addScaledVector(other, Math.sin(a));
    };
    for (let k = 0; k < SIDES; ++k) {
      const n = corner(k), m = corner(k + 1);
      const place = (end, normal) => end.clone().addScaledVector(normal, isPointed && end === from ? 0 : radius);
      for (const [end, normal] of [[from, n], [to, n], [to, m], [from, n], [to, m], [from, m]]) {
        positions.push(...place(end, normal).toArray());
        normals.push(...normal.toArray());
        colours.push(colour.r, colour.g, colour.b);
      }
    }
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.Float32BufferAttribute(positions, 3));
  geometry.setAttribute("normal", new THREE.Float32BufferAttribute(normals, 3));
  geometry.setAttribute("color", new THREE.Float32BufferAttribute(colours, 3));
  return geometry;
}

/**
 * Narrows `data.center` and `data.radius`, which all views are in proportion to, to what the camera sees near it, if the
 * scene is far larger: such as a beach with a horizon. The mesh is finest there, so that its triangles say where.
 */
function frame(data, mesh) {
  const MUCH = 2, WIDER = 2, middle = data.camera[4], count = mesh.positions.length / 9;
  data.sceneRadius = data.radius;
  if (data.camera.some((ray) => !ray) || count === 0) return;
  const eye = vector(middle.origin), direction = vector(middle.direction).normalize(), distances = [];
  const cosine = Math.min(...data.camera.map((ray) => vector(ray.direction).normalize().dot(direction)));
  for (let t = 0; t < count; ++t) {
    const d = new THREE.Vector3().fromArray(mesh.positions, 9 * t).sub(eye), length = d.length();
    if (d.dot(direction) >= cosine * length) distances.push(length);
  }
  if (distances.length === 0) return;
  const median = Float64Array.from(distances).sort()[distances.length >> 1];
  if (WIDER * MUCH * median > data.radius) return;
  data.radius = WIDER * median;
  data.center = eye.addScaledVector(direction, median).toArray();
}

class SceneView {
  /** Creates the view of `mesh`, whose positions, colours and objects are decoded. */
  constructor(data, mesh) {
    this.data = data;
    this.mesh = mesh;
    this.center = vector(data.center);
    this.radius = data.radius;
    this.far = 100 * Math.max(this.radius, 0.04 * data.sceneRadius);
    this.canvas = element("view");
    this.renderer = new THREE.WebGLRenderer({ canvas: this.canvas, antialias: true, preserveDrawingBuffer: true });
    this.renderer.setPixelRatio(Math.min(2, window.devicePixelRatio));
    this.renderer.localClippingEnabled = true;
    this.scene = new THREE.Scene();
    this.scene.background = new THREE.Color(0x14161a);
    this.plane = new THREE.Plane();
    this.addLights();
    this.addMesh();
    this.addBoxes(data.media, 0x5fb0a0);
    this.addCamera();
    this.makeCameras();
    this.frames = 0;
    new ResizeObserver(() => this.resize()).observe(this.canvas.parentElement);
    this.resize();
  }

  addLights() {
    this.scene.add(new THREE.HemisphereLight(0xffffff, 0xb8b0a4, 0.62));
    this.headLight = new THREE.DirectionalLight(0xffffff, 0.35);
    this.scene.add(this.headLight, this.headLight.target);
  }

  addMesh() {
    const { positions, colours } = this.mesh, vertexColours = new Float32Array(positions.length);
    for (let t = 0; t < colours.length / 3; ++t)
      for (let k = 0; k < 9; ++k) vertexColours[9 * t + k] = colours[3 * t + k % 3] / 255;
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(positions, 3));
    geometry.setAttribute("color", new THREE.BufferAttribute(vertexColours, 3));
    geometry.computeVertexNormals();
    // Offset in depth, so that photons and lines on the surface remain visible.
    this.material = new THREE.MeshLambertMaterial({ vertexColors: THREE.VertexColors, side: THREE.DoubleSide,
      polygonOffset: true, polygonOffsetFactor: 2, polygonOffsetUnits: 8 });
    this.surface = new THREE.Mesh(geometry, this.material);
    this.scene.add(this.surface);
  }

  addBoxes(boxes, colour) {
    for (const [lower, upper] of boxes)
      this.scene.add(new THREE.Box3Helper(new THREE.Box3().setFromPoints([vector(lower), vector(upper)]), colour));
  }

  /** Adds the frustum, with a depth of a quarter of the scene's radius, and the picture at its end. */
  addCamera() {
    this.frustum = new THREE.Group();
    this.scene.add(this.frustum);
    const rays = this.data.camera;
    if (rays.some((ray) => !ray)) return;
    const depth = 0.25 * this.radius, middle = vector(rays[4].direction);
    const corners = rays.slice(0, 4).map((ray) => {
      const d = vector(ray.direction);
      return vector(ray.origin).addScaledVector(d, depth / Math.max(0.1, d.dot(middle)));
    });
    const points = [];
    corners.forEach((corner, i) => points.push(vector(rays[i].origin), corner, corner, corners[(i + 1) % 4]));
    this.frustum.add(new THREE.LineSegments(new THREE.BufferGeometry().setFromPoints(points),
      new THREE.LineBasicMaterial({ color: 0xf0b45a })));
    const plate = new THREE.BufferGeometry();
    const [a, b, c, d] = corners;
    plate.setAttribute("position", new THREE.Float32BufferAttribute([d, c, b, d, b, a].flatMap((p) => p.toArray()), 3));
    plate.setAttribute("uv", new THREE.Float32BufferAttribute([0, 0, 1, 0, 1, 1, 0, 0, 1, 1, 0, 1], 2));
    this.texture = new THREE.CanvasTexture(element("picture"));
    this.texture.minFilter = THREE.LinearFilter;
    this.frustum.add(new THREE.Mesh(plate, new THREE.MeshBasicMaterial({ map: this.texture, side: THREE.DoubleSide })));
  }

  /** Signed axis that is nearest to the camera's up direction. */
  upAxis() {
    const rays = this.data.camera;
    if (rays.some((ray) => !ray)) return new THREE.Vector3(0, 0, 1);
    const up = vector(rays[0].direction).add(vector(rays[1].direction)).sub(vector(rays[2].direction))
      .sub(vector(rays[3].direction)).add(vector(rays[0].origin)).sub(vector(rays[3].origin));
    const size = up.toArray().map(Math.abs), k = size.indexOf(Math.max(...size));
    return new THREE.Vector3().setComponent(k, Math.sign(up.getComponent(k)) || 1);
  }

  makeCameras() {
    const r = this.radius;
    this.up = this.upAxis();
    this.perspective = new THREE.PerspectiveCamera(45, 1, r * 1e-3, this.far);
    this.orthographic = new THREE.OrthographicCamera(-r, r, r, -r, -this.far, this.far);
    for (const camera of [this.perspective, this.orthographic]) camera.up.copy(this.up);
    this.controls = new Map([this.perspective, this.orthographic].map((camera) => {
      const controls = new THREE.OrbitControls(camera, this.canvas);
      controls.enableKeys = false;
      controls.addEventListener("change", () => this.draw());
      return [camera, controls];
    }));
    this.look("camera");
  }

  /** Looks from the scene's camera, or along an axis. Returns the axis and the viewer's side of it, as arguments of
   * cut(). */
  look(name) {
    const rays = this.data.camera, middle = rays[4], r = this.radius;
    const isOrthographic = name !== "camera";
    this.camera = isOrthographic ? this.orthographic : this.perspective;
    for (const [camera, controls] of this.controls) controls.enabled = camera === this.camera;
    const controls = this.controls.get(this.camera);
    controls.target.copy(this.center);
    if (!isOrthographic && middle && rays[0] && rays[3]) {
      const top = vector(rays[0].direction).add(vector(rays[1].direction)).normalize();
      const bottom = vector(rays[2].direction).add(vector(rays[3].direction)).normalize();
      this.perspective.fov = Math.min(120, Math.max(5, THREE.Math.radToDeg(top.angleTo(bottom)) * 1.05));
      this.camera.position.copy(vector(middle.origin));
      const direction = vector(middle.direction);
      const ahead = Math.max(0.2 * r, this.center.clone().sub(this.camera.position).dot(direction));
      controls.target.copy(this.camera.position).addScaledVector(direction, ahead);
    } else {
      const side = this.up.x === 0 ? new THREE.Vector3(1, 0, 0) : new THREE.Vector3(0, 1, 0);
      const towards = { camera: side.clone().add(this.up), top: this.up.clone().addScaledVector(side, 1e-4), side,
        front: side.clone().cross(this.up) }[name];
      this.camera.position.copy(this.center).addScaledVector(towards.normalize(), 3 * r);
      this.orthographic.zoom = 1;
    }
    this.resize();
    controls.update();
    this.draw();
    if (!isOrthographic) return { axis: "", isTurned: false };
    const towards = this.camera.position.clone().sub(this.center).toArray(), size = towards.map(Math.abs);
    const k = size.indexOf(Math.max(...size));
    return { axis: AXES[k], isTurned: towards[k] < 0 };
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.canvas.parentElement;
    if (!(width > 0 && height > 0) || !this.camera) return;
    this.renderer.setSize(width, height, false);
    const aspect = width / height, half = this.radius * 1.05;
    this.perspective.aspect = aspect;
    const [w, h] = aspect > 1 ? [half * aspect, half] : [half, half / aspect];
    Object.assign(this.orthographic, { left: -w, right: w, top: h, bottom: -h });
    this.perspective.updateProjectionMatrix();
    this.orthographic.updateProjectionMatrix();
    this.draw();
  }

  setWireFrame(on) {
    this.material.wireframe = on;
    this.draw();
  }

  setOpacity(opacity) {
    Object.assign(this.material, { opacity, transparent: opacity < 1, depthWrite: opacity === 1, needsUpdate: true });
    this.draw();
  }

  /** Hides geometry above `place` (below if `isTurned`) on an axis, in scene radii from the centre; empty axis: none. */
  cut(axis, place, isTurned) {
    const normal = new THREE.Vector3(), k = AXES.indexOf(axis), side = isTurned ? 1 : -1;
    if (k >= 0) {
      normal.setComponent(k, side);
      this.plane.set(normal, -side * (this.center.getComponent(k) + place * this.radius));
    }
    this.material.clippingPlanes = k >= 0 ? [this.plane] : [];
    this.material.needsUpdate = true;
    this.draw();
  }

  /** Requests a redraw before the next frame. */
  draw() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => {
      this.waiting = false;
      // Seen from the camera's position, the picture would cover the scene.
      const eye = this.data.camera[4], away = eye ? this.camera.position.distanceTo(vector(eye.origin)) : 0;
      this.frustum.visible = this.camera !== this.perspective || away > 0.3 * this.radius;
      // So would the paths' segments from the camera.
      const isFromCamera = this.camera === this.perspective && eye && away < 0.05 * this.radius;
      if (this.fromEye) this.fromEye.visible = !isFromCamera;
      this.canvas.dataset.segmentsFromCamera = this.fromEye && !isFromCamera ? "shown" : "hidden";
      this.headLight.position.copy(this.camera.position);
      this.headLight.target.position.copy(this.controls.get(this.camera).target);
      this.renderer.render(this.scene, this.camera);
      this.canvas.dataset.frames = ++this.frames;
    });
  }

  /** First intersection of a mesh with the ray at a position of the window, of what the cut leaves; undefined if there
   * is none. Its normal is on the viewer's side. */
  firstHit(mesh, clientX, clientY) {
    const box = this.canvas.getBoundingClientRect(), ray = new THREE.Raycaster();
    ray.setFromCamera({ x: 2 * (clientX - box.left) / box.width - 1, y: 1 - 2 * (clientY - box.top) / box.height },
      this.camera);
    const clipped = this.material.clippingPlanes?.length > 0;
    const hit = ray.intersectObject(mesh).find((h) => !clipped || this.plane.distanceToPoint(h.point) >= 0);
    if (!hit) return undefined;
    const normal = hit.face.normal.clone();
    if (normal.dot(ray.ray.direction) > 0) normal.negate();
    return { point: hit.point, normal, faceIndex: hit.faceIndex };
  }

  /** Surface at a position of the window: point, unit normal towards the viewer, name, whether it is a mirror or clear
   * glass; null if there is none. */
  pick(clientX, clientY) {
    const hit = this.firstHit(this.surface, clientX, clientY);
    return hit ? { ...hit, name: this.mesh.names[this.mesh.objects[hit.faceIndex]],
      isSpecular: this.mesh.specular[hit.faceIndex] === 1 } : null;
  }

  /** Replaces the object of that name; null removes it. */
  replace(name, object) {
    this.parts ??= new Map();
    const before = this.parts.get(name);
    if (before) {
      this.scene.remove(before);
      before.traverse?.((o) => o.geometry?.dispose());
    }
    this.parts.set(name, object);
    if (object) this.scene.add(object);
    this.draw();
  }
}
