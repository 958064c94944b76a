// Shapes of a mechanism on a canvas. World coordinates are in metres, y up; `view` maps them to CSS pixels, y down.
// Sizes of symbols are multiples of U, a length in pixels that follows the zoom within limits.
const TAU = 2 * Math.PI;
const MANY = 600; // number of shapes from which links are drawn together

class Painter {
  constructor(data, motion) {
    Object.assign(this, { data, motion });
    this.bodies = new Map(Object.keys(data.bodies).map((name, k) => [name, k]));
    const owner = (name) => (this.bodies.has(name) ? name : name.replace(/\.[^.]*$/, ""));
    this.owners = new Map(data.tracks.map((name, k) => [k, owner(name)]));
    this.many = data.shapes.length > MANY;
  }

  // Everything at the motion's current time.
  paint(g, view, theme, show) {
    Object.assign(this, { g, view, theme, show });
    this.U = Math.min(26, 0.065 * view.side, Math.max(2.5, this.data.unit * view.scale));
    this.thin = Math.min(1.5, Math.max(0.75, this.U / 8));
    g.lineCap = g.lineJoin = "round";
    const rest = this.many ? this.paintMany() : this.data.shapes;
    for (const shape of rest) {
      const draw = this[`draw_${shape.draw.replace("-", "_")}`];
      if (draw) draw.call(this, shape, (shape.at || []).map((at) => this.place(at)));
    }
  }

  // [x, y, angle] of a spot in pixels; the angle is that of the world, counter-clockwise.
  place(at) {
    const [x, y, phi] = this.motion.pose(at);
    return [this.view.x + this.view.scale * x, this.view.y - this.view.scale * y, phi];
  }

  colour(name) {
    const k = this.bodies.get(name);
    return k === undefined ? this.theme.pale : this.theme.bodies[k % this.theme.bodies.length];
  }

  // Links and pins of large models: one path each.
  paintMany() {
    const { g, view, motion, U } = this;
    const rest = [];
    const links = new Path2D();
    const pins = new Path2D();
    const radius = 0.3 * U;
    for (const shape of this.data.shapes) {
      if (shape.draw === "link") {
        shape.points.forEach(([px, py], k) => {
          const [x, y] = motion.point(shape.at[0][0], px, py);
          links[k ? "lineTo" : "moveTo"](view.x + view.scale * x, view.y - view.scale * y);
        });
      } else if (shape.draw === "pin") {
        if (U < 4) continue;
        const [x, y] = this.place(shape.at[0]);
        pins.moveTo(x + radius, y);
        pins.arc(x, y, radius, 0, TAU);
      } else rest.push(shape);
    }
    g.lineWidth = Math.max(1.6, 0.5 * U);
    g.strokeStyle = this.theme.bodies[0];
    g.stroke(links);
    g.fillStyle = this.theme.ink;
    g.fill(pins);
    return rest;
  }

  // -- helpers: in the axes of a place, x along its angle and y to its left ----------------------------------------
  at([x, y, phi], draw) {
    this.g.save();
    this.g.translate(x, y);
    this.g.rotate(-phi);
    draw(this.g);
    this.g.restore();
  }

  line(points, width = this.thin, colour = this.theme.ink) {
    const { g } = this;
    g.beginPath();
    points.forEach(([x, y], k) => (k ? g.lineTo(x, y) : g.moveTo(x, y)));
    g.lineWidth = width;
    g.strokeStyle = colour;
    g.stroke();
  }

  area(fill, stroke = this.theme.ink, width = this.thin) {
    const { g } = this;
    g.fillStyle = fill;
    g.fill();
    g.lineWidth = width;
    g.strokeStyle = stroke;
    g.stroke();
  }

  circle(x, y, radius, fill, stroke, width) {
    this.g.beginPath();
    this.g.arc(x, y, radius, 0, TAU);
    this.area(fill, stroke, width);
  }

  // A line from x = a to b at height y of the current axes, hatched on one side: of fixed things.
  hatched(a, b, y, side) {
    const { g, U } = this;
    const step = 0.55 * U;
    const count = Math.max(1, Math.round((b - a) / step));
    g.beginPath();
    for (let k = 0; k < count; k += 1) {
      const x = a + ((k + 0.5) * (b - a)) / count;
      g.moveTo(x + 0.2 * U, y);
      g.lineTo(x - 0.25 * U, y + side * 0.5 * U);
    }
    g.lineWidth = this.thin * 0.8;
    g.strokeStyle = this.theme.pale;
    g.stroke();
    this.line([[a, y], [b, y]], this.thin * 1.2);
  }

  // Draws along the line from p to q: x from 0 to its length.
  along(p, q, draw) {
    const [dx, dy] = [q[0] - p[0], q[1] - p[1]];
    this.at([p[0], p[1], Math.atan2(-dy, dx)], () => draw(Math.hypot(dx, dy)));
  }

  // -- bodies ------------------------------------------------------------------------------------------------------
  draw_link(shape) {
    const { g, view, U } = this;
    const colour = this.colour(shape.name);
    g.beginPath();
    shape.points.forEach(([px, py], k) => {
      const [x, y] = this.motion.point(shape.at[0][0], px, py);
      g[k ? "lineTo" : "moveTo"](view.x + view.scale * x, view.y - view.scale * y);
    });
    if (shape.points.length > 2) g.closePath();
    const width = 0.85 * U;
    g.strokeStyle = colour;
    g.lineWidth = width;
    g.stroke();
    g.strokeStyle = g.fillStyle = mixed(colour, this.theme.paper, 0.72);
    if (shape.points.length > 2) g.fill();
    if (width > 4) {
      g.lineWidth = width - 2.5;
      g.stroke();
    }
  }

  draw_beam(shape) {
    const { view } = this;
    const { points, colours } = this.motion.curve(shape.beam, this.show.deflection);
    const to = points.map(([x, y]) => [view.x + view.scale * x, view.y - view.scale * y]);
    const width = Math.max(2.5, 0.42 * this.U);
    this.line(to, width + 2.5, this.colour(shape.name));
    const plain = mixed(this.colour(shape.name), this.theme.paper, 0.72);
    for (let k = 0; k + 1 < to.length; k += 1)
      this.line([to[k], to[k + 1]], width, mixed(plain, this.theme.hot, (colours[k] + colours[k + 1]) / 2));
  }

  draw_mass(shape, [p]) {
    this.circle(p[0], p[1], 0.72 * this.U, mixed(this.colour(shape.name), this.theme.paper, 0.25));
  }

  draw_hub(shape, [p]) {
    const radius = 0.95 * this.U;
    this.circle(p[0], p[1], radius, mixed(this.colour(shape.name), this.theme.paper, 0.72), this.colour(shape.name));
    this.at(p, () => this.line([[0, 0], [radius, 0]], this.thin, this.colour(shape.name)));
  }

  // A shape of the model, in metres: areas, lines or an ellipse; its colours, or those of the body.
  draw_outline(shape, [p]) {
    const { g } = this;
    const { scale } = this.view;
    const body = this.colour(shape.name);
    this.at(p, () => {
      g.beginPath();
      for (const part of shape.parts) {
        if (shape.form === "ellipse") {
          const [a, b, phi] = shape.axes;
          g.ellipse(scale * part[0][0], -scale * part[0][1], scale * a, scale * b, -phi, 0, TAU);
        } else {
          part.forEach(([x, y], k) => g[k ? "lineTo" : "moveTo"](scale * x, -scale * y));
          if (shape.form === "area") g.closePath();
        }
      }
      if (shape.fill !== "none" && shape.form !== "line") {
        g.fillStyle = shape.fill || mixed(body, this.theme.paper, 0.72);
        g.fill("evenodd");
      }
      if (shape.line === "none") return;
      g.lineWidth = Math.max(1.2, scale * shape.width);
      g.strokeStyle = shape.line || body;
      g.stroke();
    });
  }

  draw_backdrop(shape, places) {
    this.draw_outline(shape, places);
  }

  draw_block(shape, [p, axis]) {
    const { U } = this;
    const colour = this.colour(this.owners.get(shape.at[0][0]));
    this.at([p[0], p[1], axis[2]], (g) => {
      g.beginPath();
      g.rect(-1.15 * U, -0.78 * U, 2.3 * U, 1.56 * U);
      this.area(mixed(colour, this.theme.paper, 0.6), mixed(colour, this.theme.ink, 0.4));
    });
  }

  draw_wheel(shape, [p]) {
    const colour = this.colour(this.owners.get(shape.at[0][0]));
    const radius = shape.radius * this.view.scale;
    this.circle(p[0], p[1], radius, mixed(colour, this.theme.paper, 0.85), colour, 2);
    this.at(p, () => {
      this.line([[-radius, 0], [radius, 0]], this.thin, colour);
      this.line([[0, -radius], [0, radius]], this.thin, mixed(colour, this.theme.paper, 0.5));
      this.g.beginPath();
      this.g.arc(0.78 * radius, 0, Math.max(1.5, 0.07 * radius), 0, TAU);
      this.g.fillStyle = colour;
      this.g.fill();
    });
    this.circle(p[0], p[1], Math.max(2, 0.25 * this.U), this.theme.paper);
  }

  // -- joints ------------------------------------------------------------------------------------------------------
  draw_pin(shape, [p]) {
    this.circle(p[0], p[1], Math.max(1.5, 0.27 * this.U), this.theme.paper);
  }

  draw_support(shape, [p]) {
    const { U } = this;
    const down = shape.side < 0 ? 1 : -1;
    this.at([p[0], p[1], 0], (g) => {
      g.beginPath();
      g.moveTo(0, 0);
      g.lineTo(-0.8 * U, down * 1.25 * U);
      g.lineTo(0.8 * U, down * 1.25 * U);
      g.closePath();
      this.area(this.theme.shade);
      this.hatched(-1.25 * U, 1.25 * U, down * 1.25 * U, down);
    });
  }

  draw_wall(shape, [p, q]) {
    const { U } = this;
    const angle = Math.hypot(q[0] - p[0], q[1] - p[1]) < 1e-6 ? p[2] : Math.atan2(p[1] - q[1], q[0] - p[0]);
    this.at([p[0], p[1], angle + Math.PI / 2], () => this.hatched(-1.3 * U, 1.3 * U, 0, -1));
  }

  draw_guide(shape, [p]) {
    const { U } = this;
    const [a, b] = [shape.from * this.view.scale - 2 * U, shape.to * this.view.scale + 2 * U];
    const side = shape.side < 0 ? 1 : -1;
    this.at(p, () => {
      if (shape.fixed) this.hatched(a, b, side * 0.8 * U, side);
      else this.line([[a, side * 0.8 * U], [b, side * 0.8 * U]], 0.3 * U, this.theme.pale);
    });
  }

  draw_slot(shape, [p]) {
    const [a, b] = [shape.from * this.view.scale, shape.to * this.view.scale];
    this.at(p, () => {
      this.line([[a, 0], [b, 0]], 0.95 * this.U, this.theme.pale);
      this.line([[a, 0], [b, 0]], 0.95 * this.U - 2 * this.thin, this.theme.paper);
    });
  }

  draw_floor(shape, [p]) {
    const [a, b] = [shape.from * this.view.scale, shape.to * this.view.scale];
    this.at(p, () => (shape.fixed ? this.hatched(a, b, 0, 1) : this.line([[a, 0], [b, 0]], 2 * this.thin)));
  }

  draw_weld(shape, [p]) {
    const r = 0.32 * this.U;
    this.at(p, (g) => {
      g.beginPath();
      g.rect(-r, -r, 2 * r, 2 * r);
      g.fillStyle = this.theme.ink;
      g.fill();
    });
  }

  draw_blade(shape, [p]) {
    this.at(p, () => this.line([[-1.1 * this.U, 0], [1.1 * this.U, 0]], Math.max(2.5, 0.3 * this.U)));
  }

  draw_mark(shape, [p]) {
    const r = 0.5 * this.U;
    this.at([p[0], p[1], p[2] + Math.PI / 4], (g) => {
      g.beginPath();
      g.rect(-r, -r, 2 * r, 2 * r);
      this.area(this.theme.paper);
    });
  }

  draw_rod(shape, [p, q]) {
    this.line([p, q], Math.max(2, 0.22 * this.U), this.theme.rod);
  }

  // bodies of projected models in space
  draw_bar(shape, [p, q]) {
    this.line([p, q], Math.max(3, 0.5 * this.U), this.colour(shape.name));
  }

  draw_disc(shape, points) {
    const colour = this.colour(shape.name);
    this.g.beginPath();
    points.forEach(([x, y], k) => this.g[k ? "lineTo" : "moveTo"](x, y));
    this.g.closePath();
    this.area(mixed(colour, this.theme.paper, 0.78), colour);
  }

  draw_dashed(shape, [p, q]) {
    this.g.setLineDash([5, 4]);
    this.line([p, q], this.thin, this.theme.force);
    this.g.setLineDash([]);
  }
}
