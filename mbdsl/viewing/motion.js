// Poses between the frames of the page. A track has several numbers: (x, y, angle) in the plane, in space a position
// and a unit quaternion; `space/motion.js` has the latter.

// Points of a beam with their distance from the line between the ends magnified.
function magnified(points, factor) {
  if (factor === 1) return points;
  const [first, last] = [points[0], points[points.length - 1]];
  return points.map((p, j) => {
    const part = j / (points.length - 1);
    return p.map((x, d) => {
      const straight = first[d] + (last[d] - first[d]) * part;
      return straight + factor * (x - straight);
    });
  });
}

class Tracks {
  constructor(data, width) {
    this.t = decoded(data.t);
    this.raw = decoded(data.poses);
    this.scale = data.poses.scale; // of positions and of angles or quaternions, per unit of the stored numbers
    this.width = width;
    this.count = data.tracks.length;
    this.now = new Float64Array(width * this.count);
    this.curves = data.curves.map((c) => ({ ...c, numbers: decoded(c.points), shades: decoded(c.colours) }));
    this.seek(this.t[0]);
  }

  seek(time) {
    const [row, part] = between(this.t, time);
    this.time = Math.min(this.t[this.t.length - 1], Math.max(this.t[0], time));
    const all = this.width * this.count;
    const next = part > 0 ? row + 1 : row;
    const [a, b] = [all * row, all * next];
    let share = part;
    for (let k = 0; k < all && share > 0; k += this.width)
      if (this.turn(a + k, b + k) > TURN) share = part < 0.5 ? 0 : 1;
    Object.assign(this, { row, next, share });
    for (let k = 0; k < all; k += this.width) this.blend(k, a + k, b + k);
  }

  // The number at index i of a position, on the way to that at index j.
  length(i, j) {
    return (this.raw[i] + (this.raw[j] - this.raw[i]) * this.share) * this.scale[0];
  }

  // The points of a beam, with its distance from the line between its ends magnified, and colours from 0 to 1.
  curve(k, factor) {
    const { numbers, shades, count, points } = this.curves[k];
    const [a, b] = [2 * count * this.row, 2 * count * this.next];
    const at = (i) => (numbers[a + i] + (numbers[b + i] - numbers[a + i]) * this.share) * points.scale;
    const found = Array.from({ length: count }, (_, j) => [at(2 * j), at(2 * j + 1)]);
    const own = shades.subarray(count * this.row, count * (this.row + 1));
    return { points: magnified(found, factor), colours: Array.from(own, (c) => c / 255) };
  }

  // The path of a point over all frames.
  path(at) {
    const [{ time }, k] = [this, this.width * at[0]];
    const found = Array.from(this.t, (_, row) => {
      const i = this.width * this.count * row + k;
      this.blend(k, i, i);
      return this.point(at);
    });
    this.seek(time);
    return found;
  }
}

class PlaneMotion extends Tracks {
  static columns = ["x [m]", "y [m]", "angle [rad]"];

  constructor(data) {
    super(data, 3);
  }

  // The rotation from index i to j; angles are stored modulo a turn where positions are stored as integers.
  turned(i, j) {
    const by = (this.raw[j + 2] - this.raw[i + 2]) * this.scale[1];
    return by - 2 * Math.PI * Math.round(by / (2 * Math.PI));
  }

  turn(i, j) {
    return Math.abs(this.turned(i, j));
  }

  blend(k, i, j) {
    this.now[k] = this.length(i, j);
    this.now[k + 1] = this.length(i + 1, j + 1);
    this.now[k + 2] = this.raw[i + 2] * this.scale[1] + this.turned(i, j) * this.share;
  }

  pose([track, px = 0, py = 0, phi = 0]) {
    if (track < 0) return [px, py, phi];
    const [x, y, turn] = this.now.subarray(3 * track, 3 * track + 3);
    const [c, s] = [Math.cos(turn), Math.sin(turn)];
    return [x + c * px - s * py, y + s * px + c * py, turn + phi];
  }

  point(at) {
    return this.pose(at).slice(0, 2);
  }
}
