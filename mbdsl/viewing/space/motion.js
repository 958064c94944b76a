// Poses in space: positions, and unit quaternions (w, x, y, z).

// The vector v turned by the quaternion at index i of p: v + 2 u x (w v + u x v).
function turnedBy(p, i, [x, y, z]) {
  const [w, a, b, c] = [p[i], p[i + 1], p[i + 2], p[i + 3]];
  const [l, m, n] = [w * x + b * z - c * y, w * y + c * x - a * z, w * z + a * y - b * x];
  return [x + 2 * (b * n - c * m), y + 2 * (c * l - a * n), z + 2 * (a * m - b * l)];
}

function product([w, x, y, z], [a, b, c, d]) {
  return [
    w * a - x * b - y * c - z * d,
    w * b + x * a + y * d - z * c,
    w * c + y * a + z * b - x * d,
    w * d + z * a + x * c - y * b,
  ];
}

class SpaceMotion extends Tracks {
  static columns = ["x [m]", "y [m]", "z [m]", "p0", "p1", "p2", "p3"];

  constructor(data) {
    super(data, 7);
  }

  // The cosine of half the angle between the attitudes at two indices, negative where the quaternions differ in sign.
  near(i, j) {
    const { raw, scale } = this;
    let sum = 0;
    for (let k = 3; k < 7; k += 1) sum += raw[i + k] * raw[j + k];
    return sum * scale[1] ** 2;
  }

  turn(i, j) {
    return 2 * Math.acos(Math.min(1, Math.abs(this.near(i, j))));
  }

  blend(k, i, j) {
    const { raw, now, share } = this;
    for (let d = 0; d < 3; d += 1) now[k + d] = this.length(i + d, j + d);
    const sign = this.near(i, j) < 0 ? -1 : 1;
    for (let d = 3; d < 7; d += 1) now[k + d] = raw[i + d] + (sign * raw[j + d] - raw[i + d]) * share;
    this.normalise(k);
  }

  normalise(k) {
    const size = Math.hypot(...this.now.subarray(k + 3, k + 7));
    for (let d = 3; d < 7; d += 1) this.now[k + d] /= size;
  }

  // The position of a place in the world.
  point([track, x = 0, y = 0, z = 0]) {
    if (track < 0) return [x, y, z];
    return turnedBy(this.now, 7 * track + 3, [x, y, z]).map((p, k) => p + this.now[7 * track + k]);
  }

  attitude([track, , , , ...p]) {
    const own = p.length ? p : [1, 0, 0, 0];
    return track < 0 ? own : product([...this.now.subarray(7 * track + 3, 7 * track + 7)], own);
  }

  pose(at) {
    return [...this.point(at), ...this.attitude(at)];
  }
}
