// Poses in space between the frames of the page: positions, and unit quaternions (w, x, y, z).

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

class Motion {
  static columns = ["x [m]", "y [m]", "z [m]", "p0", "p1", "p2", "p3"];

  constructor(data) {
    this.t = decoded(data.t);
    this.raw = decoded(data.poses);
    this.scale = data.poses.scale; // of positions and of quaternions, per unit of the stored numbers
    this.count = data.tracks.length;
    this.now = new Float64Array(7 * this.count);
    this.curves = [];
    this.seek(this.t[0]);
  }

  // The cosine of half the angle between the attitudes at two indices, negative where the quaternions differ in sign.
  near(i, j) {
    const { raw, scale } = this;
    let sum = 0;
    for (let k = 3; k < 7; k += 1) sum += raw[i + k] * raw[j + k];
    return sum * scale[1] ** 2;
  }

  seek(time) {
    const [row, part] = between(this.t, time);
    this.time = Math.min(this.t[this.t.length - 1], Math.max(this.t[0], time));
    const { raw, count, now, scale } = this;
    const next = part > 0 ? row + 1 : row;
    const [a, b] = [7 * count * row, 7 * count * next];
    let share = part;
    for (let k = 0; k < 7 * count && share > 0; k += 7)
      if (Math.abs(this.near(a + k, b + k)) < Math.cos(TURN / 2)) share = part < 0.5 ? 0 : 1;
    [this.row, this.next, this.share] = [row, next, share];
    for (let k = 0; k < 7 * count; k += 7) {
      const [i, j] = [a + k, b + k];
      for (let d = 0; d < 3; d += 1) now[k + d] = (raw[i + d] + (raw[j + d] - raw[i + d]) * share) * scale[0];
      const sign = this.near(i, j) < 0 ? -1 : 1;
      let size = 0;
      for (let d = 3; d < 7; d += 1) {
        now[k + d] = raw[i + d] + (sign * raw[j + d] - raw[i + d]) * share;
        size += now[k + d] ** 2;
      }
      for (let d = 3; d < 7; d += 1) now[k + d] /= Math.sqrt(size);
    }
  }

  // The position of a place in the world.
  point([track, ...r]) {
    if (track < 0) return r.slice(0, 3);
    const v = turnedBy(this.now, 7 * track + 3, r);
    return v.map((x, k) => x + this.now[7 * track + k]);
  }

  attitude([track, , , , ...p]) {
    const own = p.length ? p : [1, 0, 0, 0];
    return track < 0 ? own : product([...this.now.subarray(7 * track + 3, 7 * track + 7)], own);
  }

  pose(at) {
    return [...this.point(at), ...this.attitude(at)];
  }

  // The path of a point over all frames.
  path([track, ...r]) {
    const { raw, scale, count, t } = this;
    return Array.from(t, (_, row) => {
      const i = 7 * (count * row + track);
      const p = raw.slice(i + 3, i + 7);
      const size = Math.hypot(...p);
      return turnedBy(Array.from(p, (x) => x / size), 0, r).map((x, k) => x + raw[i + k] * scale[0]);
    });
  }
}
