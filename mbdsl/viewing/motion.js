// Poses between the frames of the page, in the plane.
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

class Motion {
  static columns = ["x [m]", "y [m]", "angle [rad]"];

  constructor(data) {
    this.t = decoded(data.t);
    this.raw = decoded(data.poses);
    this.scale = data.poses.scale; // of positions and of angles, per unit of the stored numbers
    this.count = data.tracks.length;
    this.now = new Float64Array(3 * this.count);
    this.cos = new Float64Array(this.count);
    this.sin = new Float64Array(this.count);
    this.curves = data.curves.map((c) => ({ ...c, numbers: decoded(c.points), shades: decoded(c.colours) }));
    this.seek(this.t[0]);
  }

  // Angles are stored modulo a turn where positions are stored as integers.
  turned(a, b) {
    return b - a - 2 * Math.PI * Math.round((b - a) / (2 * Math.PI));
  }

  seek(time) {
    const [row, part] = between(this.t, time);
    this.time = Math.min(this.t[this.t.length - 1], Math.max(this.t[0], time));
    const { raw, count, now } = this;
    const [length, angle] = this.scale;
    const next = part > 0 ? row + 1 : row;
    let [a, b] = [3 * count * row, 3 * count * next];
    let share = part;
    for (let k = 2; k < 3 * count && share > 0; k += 3)
      if (Math.abs(this.turned(raw[a + k] * angle, raw[b + k] * angle)) > TURN) share = part < 0.5 ? 0 : 1;
    this.row = row;
    this.next = next;
    this.share = share;
    for (let k = 0; k < count; k += 1) {
      const [i, j] = [a + 3 * k, b + 3 * k];
      now[3 * k] = (raw[i] + (raw[j] - raw[i]) * share) * length;
      now[3 * k + 1] = (raw[i + 1] + (raw[j + 1] - raw[i + 1]) * share) * length;
      const from = raw[i + 2] * angle;
      const phi = from + this.turned(from, raw[j + 2] * angle) * share;
      now[3 * k + 2] = phi;
      this.cos[k] = Math.cos(phi);
      this.sin[k] = Math.sin(phi);
    }
  }

  // A point at (px, py) of a track.
  point(track, px, py) {
    if (track < 0) return [px, py];
    const [c, s] = [this.cos[track], this.sin[track]];
    return [this.now[3 * track] + c * px - s * py, this.now[3 * track + 1] + s * px + c * py];
  }

  pose([track, x = 0, y = 0, phi = 0]) {
    return [...this.point(track, x, y), track < 0 ? phi : this.now[3 * track + 2] + phi];
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
  path([track, px = 0, py = 0]) {
    const [length, angle] = this.scale;
    const found = [];
    for (let row = 0; row < this.t.length; row += 1) {
      const i = 3 * (this.count * row + track);
      const phi = this.raw[i + 2] * angle;
      const [c, s] = [Math.cos(phi), Math.sin(phi)];
      found.push([this.raw[i] * length + c * px - s * py, this.raw[i + 1] * length + s * px + c * py]);
    }
    return found;
  }
}
