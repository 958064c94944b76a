// The display list of a mechanism on a canvas, as picture.py draws it. World coordinates are in metres, y up; `view`
// maps them to CSS pixels, y down. Sizes of symbols are multiples of U, a length in pixels that follows the zoom within
// limits.
const TAU = 2 * Math.PI;
const MANY = 600; // number of items from which neighbours of one look are drawn together
const EDGE = 2.5; // width of both edges of a line together [px]
const SHORT = 6; // units of x along a line that is shorter than this number of them are a part of it
const THIN = [0, 0, 0, 1];

class Painter {
  constructor(data, motion) {
    const look = ({ at, metres, units, ...rest }) => JSON.stringify(rest);
    const groups = [];
    let before = null;
    for (const item of data.items) {
      const own = data.items.length > MANY ? look(item) : null;
      if (own && own === before) groups[groups.length - 1].push(item);
      else groups.push([item]);
      before = own;
    }
    Object.assign(this, { data, motion, groups });
  }

  resize() {}

  // Everything at the motion's current time.
  paint(g, view, theme, show) {
    Object.assign(this, { g, view, theme, show });
    this.U = Math.min(26, 0.065 * view.side, Math.max(2.5, this.data.unit * view.scale));
    this.thin = Math.min(1.5, Math.max(0.75, this.U / 8));
    for (const group of this.groups) {
      const item = group[0];
      if (item.curve !== undefined) {
        this.paintBeam(item);
        continue;
      }
      if (item.hatch) for (const own of group) this.hatch(this.points(own), item.hatch);
      g.beginPath();
      for (const own of group) (own.radius ? this.traceCircle(own) : this.tracePath(own));
      this.finish(item);
    }
  }

  // [x, y, angle] of a frame in pixels; the angle is that of the world, counter-clockwise.
  place(at) {
    const [x, y, phi] = this.motion.pose(at);
    return [...this.pixel([x, y]), phi];
  }

  // The origin of a frame and the ends of its axes in pixels.
  axes(at) {
    const [x, y, phi] = this.place(at);
    const [c, s] = [AXIS * Math.cos(phi), AXIS * Math.sin(phi)];
    return [[x, y], [x + c, y - s], [x - s, y - c]];
  }

  pixel([x, y]) {
    return [this.view.x + this.view.scale * x, this.view.y - this.view.scale * y];
  }

  // -- sizes and colours -------------------------------------------------------------------------------------------
  length([least = 0, units = 0, metres = 0, thin = 0]) {
    return Math.max(least, units * this.U + metres * this.view.scale + thin * this.thin);
  }

  colour(c) {
    if (!c) return null;
    if (typeof c === "string") return this.theme[c] || c;
    return mixed(this.theme[c[0]] || c[0], this.theme[c[1]] || c[1], c[2]);
  }

  // Fill and stroke the path that is traced.
  finish({ fill, stroke = "ink", edge, width = THIN, hatch, dashed }) {
    const { g } = this;
    let thick = this.length(width) * (hatch ? 1.2 : 1);
    if (edge) {
      this.stroke(edge, thick);
      thick -= EDGE;
    }
    if (fill) {
      g.fillStyle = this.colour(fill);
      g.fill("evenodd");
    }
    if (dashed) g.setLineDash([5, 4]);
    if (stroke && thick > (edge ? 1.5 : 0)) this.stroke(stroke, thick);
    if (dashed) g.setLineDash([]);
  }

  stroke(colour, width) {
    this.g.lineWidth = width;
    this.g.strokeStyle = this.colour(colour);
    this.g.stroke();
  }

  // -- items -------------------------------------------------------------------------------------------------------
  traceCircle({ at, radius }) {
    const [[x, y], r] = [this.place(at[0]), this.length(radius)];
    this.g.moveTo(x + r, y);
    this.g.arc(x, y, r, 0, TAU);
  }

  tracePath(path) {
    const { g } = this;
    const points = this.points(path);
    const cuts = path.cuts || [];
    if (path.curved) {
      const [p, q, m] = points;
      g.moveTo(...p.slice(0, 2));
      return g.quadraticCurveTo(2 * m[0] - (p[0] + q[0]) / 2, 2 * m[1] - (p[1] + q[1]) / 2, q[0], q[1]);
    }
    points.forEach(([x, y], k) => {
      const begins = k === 0 || cuts.includes(k);
      if (begins && k && path.closed) g.closePath();
      g[begins ? "moveTo" : "lineTo"](x, y);
    });
    return path.closed && g.closePath();
  }

  // The points of a path in pixels.
  points({ at, axes = "own", metres, units, share, state, low = 0, high = 0 }) {
    if (axes === "on") return at.map((one) => this.place(one));
    const { scale } = this.view;
    const places = at.map((one) => this.place(one));
    let [[x, y, phi], unit, [part, turn, length]] = [places[0], this.U, [0, 0, 0]];
    if (axes === "along") {
      const [dx, dy] = [places[1][0] - x, places[1][1] - y];
      length = Math.hypot(dx, dy);
      if (length > 1e-6) phi = Math.atan2(-dy, dx);
      unit = Math.min(unit, length / SHORT);
      part = high > low ? Math.min(1, Math.max(0, (length / scale - low) / (high - low))) : 0.5;
    } else if (axes === "turned") {
      turn = Math.max(-TAU, Math.min(2 * TAU, phi - places[1][2]));
      phi = places[1][2];
    }
    return Array.from({ length: (metres || units).length }, (_, k) => {
      const [m, u, s] = [metres ? metres[k] : [0, 0], units ? units[k] : [0, 0], state ? state[k] : 0];
      const px = scale * m[0] + unit * (u[0] + s * part) + (share ? share[k] * length : 0);
      const py = scale * m[1] + this.U * u[1];
      const [c, d] = [Math.cos(phi + turn * s), Math.sin(phi + turn * s)];
      return [x + c * px - d * py, y - d * px - c * py];
    });
  }

  // Short lines on one side of a line: of fixed things.
  hatch([[x, y], [x1, y1]], side) {
    const { g, U } = this;
    const [dx, dy] = [x1 - x, y1 - y];
    const length = Math.hypot(dx, dy);
    if (!(length > 0)) return;
    const [c, s] = [dx / length, dy / length];
    const count = Math.max(1, Math.round(length / (0.55 * U)));
    g.beginPath();
    for (let k = 0; k < count; k += 1) {
      const [px, py] = [x + ((k + 0.5) / count) * dx, y + ((k + 0.5) / count) * dy];
      g.moveTo(px + 0.2 * U * c, py + 0.2 * U * s);
      g.lineTo(px + U * (0.5 * side * s - 0.25 * c), py - U * (0.5 * side * c + 0.25 * s));
    }
    this.stroke("pale", 0.8 * this.thin);
  }

  // The curve of a beam, in shades of its strain.
  paintBeam({ curve, stroke, edge, width = [2.5, 0.42] }) {
    const { points, colours } = this.motion.curve(curve, this.show.deflection);
    const to = points.map((p) => this.pixel(p));
    const thick = this.length(width);
    polyline(this.g, to, thick + EDGE, this.colour(edge));
    for (let k = 0; k + 1 < to.length; k += 1) {
      const shade = mixed(this.colour(stroke), this.theme.hot, (colours[k] + colours[k + 1]) / 2);
      polyline(this.g, [to[k], to[k + 1]], thick, shade);
    }
  }
}
