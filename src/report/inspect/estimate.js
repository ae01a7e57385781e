// Density estimate at a point of a surface: its photons, the part of the kernel's support that is surface, and the
// irradiance with its standard error.

/** Integral of the Epanechnikov kernel over a disc, by q = d²/r². */
const kernelPart = (q) => q * (2 - q);

/**
 * Surface around a point, on rings and in directions of its tangent plane: which cells are surface, and how far
 * the nearest wall is. Triangles with an angle of more than 45° to the plane are walls; light differs beyond them.
 */
class Surroundings {
  /** `smallest` and `largest`: radii of the estimates [scene units]. */
  constructor(positions, point, normal, smallest, largest) {
    Object.assign(this, { DIRECTIONS: 64, RINGS: 96, point, normal, largest });
    this.first = smallest / 4; // smaller discs count as surface
    this.x = new THREE.Vector3(Math.abs(normal.x) < 0.5 ? 1 : 0, Math.abs(normal.x) < 0.5 ? 0 : 1, 0).cross(normal).normalize();
    this.y = new THREE.Vector3().crossVectors(normal, this.x);
    this.isSurface = new Uint8Array(this.DIRECTIONS * this.RINGS);
    this.walls = new Float64Array(this.DIRECTIONS).fill(Infinity);
    this.addTriangles(positions);
    this.sumRings();
  }

  ringRadius(k) { return this.first * (this.largest / this.first) ** (k / this.RINGS); }
  ringAt(radius) { return Math.floor(this.RINGS * Math.log(radius / this.first) / Math.log(this.largest / this.first)); }
  angleOf(x, y) { return (Math.atan2(y, x) / (2 * Math.PI) + 1) % 1 * this.DIRECTIONS; }
  /** Coordinates of a point in the frame of the tangent plane; the third is its height. */
  local(x, y, z) {
    const { point, normal } = this, d = [x - point.x, y - point.y, z - point.z];
    return [this.x, this.y, normal].map((axis) => d[0] * axis.x + d[1] * axis.y + d[2] * axis.z);
  }

  addTriangles(positions) {
    const { point, largest } = this, low = [], high = [];
    for (let t = 0; t < positions.length; t += 9) {
      for (let c = 0; c < 3; ++c) {
        const a = positions[t + c], b = positions[t + 3 + c], d = positions[t + 6 + c];
        low[c] = Math.min(a, b, d);
        high[c] = Math.max(a, b, d);
      }
      if (low[0] > point.x + largest || high[0] < point.x - largest || low[1] > point.y + largest
        || high[1] < point.y - largest || low[2] > point.z + largest || high[2] < point.z - largest) continue;
      this.addTriangle([0, 3, 6].map((k) => this.local(positions[t + k], positions[t + k + 1], positions[t + k + 2])));
    }
  }

  addTriangle(corners) {
    const [a, b, c] = corners.map((p) => new THREE.Vector3().fromArray(p));
    const normal = b.clone().sub(a).cross(c.clone().sub(a));
    const size = normal.length(), flat = Math.abs(normal.z) / size;
    if (!(size > 0)) return;
    if (flat < Math.SQRT1_2) this.addWall(corners);
    else this.addSurface(corners);
  }

  /** Adds the line in which a triangle cuts a plane just above the surface. */
  addWall(corners) {
    const height = 0.02 * this.first * 4, cuts = [];
    corners.forEach((p, i) => {
      const q = corners[(i + 1) % 3], t = (height - p[2]) / (q[2] - p[2]);
      if (t >= 0 && t <= 1) cuts.push([p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])]);
    });
    if (cuts.length < 2) return;
    const [[px, py], [qx, qy]] = cuts, dx = qx - px, dy = qy - py;
    for (let i = 0; i < this.DIRECTIONS; ++i) {
      const a = 2 * Math.PI * (i + 0.5) / this.DIRECTIONS, ux = Math.cos(a), uy = Math.sin(a);
      const across = ux * dy - uy * dx, distance = (px * dy - py * dx) / across, along = (px * uy - py * ux) / across;
      if (distance > 0 && along >= 0 && along <= 1) this.walls[i] = Math.min(this.walls[i], distance);
    }
  }

  /** Marks the cells of a triangle that is nearly in the tangent plane. */
  addSurface([a, b, c]) {
    const side = (p, q, x, y) => (q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x - p[0]);
    const isInside = (x, y) => {
      const s = [side(a, b, x, y), side(b, c, x, y), side(c, a, x, y)];
      return s.every((v) => v >= 0) || s.every((v) => v <= 0);
    };
    const area = side(a, b, c[0], c[1]);
    if (area === 0) return;
    const heightAt = (x, y) => (side(b, c, x, y) * a[2] + side(c, a, x, y) * b[2] + side(a, b, x, y) * c[2]) / area;
    const far = Math.max(...[a, b, c].map((p) => Math.hypot(p[0], p[1]))), holdsCentre = isInside(0, 0);
    const middle = Math.atan2(a[1] + b[1] + c[1], a[0] + b[0] + c[0]);
    const spread = holdsCentre ? Math.PI : Math.max(...[a, b, c].map((p) => {
      const d = Math.atan2(p[1], p[0]) - middle;
      return Math.abs(Math.atan2(Math.sin(d), Math.cos(d)));
    }));
    const steps = Math.min(this.DIRECTIONS, Math.ceil(2 * spread / (2 * Math.PI) * this.DIRECTIONS) + 2);
    const start = Math.floor(this.angleOf(Math.cos(middle - spread), Math.sin(middle - spread))) - 1 + this.DIRECTIONS;
    const lastRing = Math.min(this.RINGS - 1, this.ringAt(far));
    for (let s = 0; s <= steps; ++s) {
      const i = (start + s) % this.DIRECTIONS, angle = 2 * Math.PI * (i + 0.5) / this.DIRECTIONS;
      for (let k = 0; k <= lastRing; ++k) {
        const r = Math.sqrt((this.ringRadius(k) ** 2 + this.ringRadius(k + 1) ** 2) / 2);
        const x = r * Math.cos(angle), y = r * Math.sin(angle);
        if (isInside(x, y) && Math.abs(heightAt(x, y)) <= FLAT * r) this.isSurface[k * this.DIRECTIONS + i] = 1;
      }
    }
  }

  /** Computes the fraction of each ring that is surface and is not behind a wall. */
  sumRings() {
    this.fractions = Array.from({ length: this.RINGS }, (_, k) => {
      let count = 0;
      for (let i = 0; i < this.DIRECTIONS; ++i)
        count += this.isSurface[k * this.DIRECTIONS + i] && this.ringRadius(k + 0.5) <= this.walls[i] ? 1 : 0;
      return count / this.DIRECTIONS;
    });
  }

  /** Whether no wall is between the centre and a point. */
  sees(x, y, z) {
    const [u, v] = this.local(x, y, z);
    return Math.hypot(u, v) <= this.walls[Math.floor(this.angleOf(u, v)) % this.DIRECTIONS];
  }

  /** Fraction of the kernel's weight that is on the surface. */
  covered(radius) {
    let part = kernelPart(Math.min(1, (this.first / radius) ** 2));
    for (let k = 0; k < this.RINGS; ++k) {
      const inner = Math.min(1, (this.ringRadius(k) / radius) ** 2), outer = Math.min(1, (this.ringRadius(k + 1) / radius) ** 2);
      part += this.fractions[k] * (kernelPart(outer) - kernelPart(inner));
    }
    return part;
  }
}

/** Tangent of the largest angle between the surface's plane and the way to a photon of the same surface. */
const FLAT = 0.15;

/** Photons near a point on its side of the surface, the nearest first, and the surface around them. */
class Estimate {
  constructor(photons, mesh, { point, normal }, sceneRadius) {
    const { count, positions, normals } = photons, MOST = 5000, farthest = 0.25 * sceneRadius, found = [];
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
    found.length = Math.min(found.length, MOST);
    this.smallest = Math.sqrt(found[Math.min(3, found.length - 1)]?.distance2 ?? 1e-4 * farthest ** 2) * 1.01;
    this.largest = Math.max(1.01 * this.smallest, Math.sqrt(found.at(-1)?.distance2 ?? farthest * farthest) * 1.001);
    this.around = new Surroundings(mesh.positions, point, normal, this.smallest, this.largest);
    this.powers = photons.powers;
    this.found = found.filter(({ index: i }) => this.around.sees(positions[3 * i], positions[3 * i + 1], positions[3 * i + 2]));
  }

  /** Irradiance within a radius, divided by the covered part of the kernel, and its standard error. */
  at(radius) {
    const sum = [0, 0, 0], r2 = radius * radius, covered = this.around.covered(radius);
    let squares = 0, count = 0;
    for (const { index, distance2 } of this.found) {
      if (distance2 >= r2) break;
      const weight = 2 / (Math.PI * r2 * covered) * (1 - distance2 / r2);
      for (let c = 0; c < 3; ++c) sum[c] += weight * this.powers[3 * index + c];
      squares += (weight * luminance(this.powers[3 * index], this.powers[3 * index + 1], this.powers[3 * index + 2])) ** 2;
      ++count;
    }
    return { value: sum, y: luminance(...sum), count, error: Math.sqrt(squares), covered };
  }

  /** Radius of the disc that contains this number of photons. */
  radiusOf(number) {
    const photon = this.found[Math.max(0, Math.min(number, this.found.length) - 1)];
    return photon ? Math.sqrt(photon.distance2) * (1 + 1e-6) : this.largest;
  }
}
