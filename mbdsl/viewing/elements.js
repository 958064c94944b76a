// Springs, dampers, actuators and drives, in the axes of the line between their ends; further methods of Painter.
Object.assign(Painter.prototype, {
  // A zigzag from x = a to b at height y; the number of its coils follows from the mean length.
  zigzag(a, b, y, height, mean) {
    const coils = Math.min(24, Math.max(3, Math.round(mean / this.data.unit / 1.1)));
    const lead = Math.min(0.8 * this.U, 0.15 * (b - a));
    const step = (b - a - 2 * lead) / (2 * coils);
    const points = [[a, y], [a + lead, y]];
    for (let k = 0; k < 2 * coils; k += 1) points.push([a + lead + (k + 0.5) * step, y + (k % 2 ? -height : height)]);
    points.push([b - lead, y], [b, y]);
    this.line(points, 1.3 * this.thin, this.theme.force);
  },

  // A cylinder from the left and a piston from the right, at the part of its stroke.
  dashpot(a, b, y, height, part, width = 1.3 * this.thin) {
    const colour = this.theme.force;
    const length = Math.min(3 * this.U, 0.45 * (b - a));
    const from = a + 0.25 * (b - a - length);
    const piston = from + (0.2 + 0.6 * part) * length;
    this.line([[a, y], [from, y]], width, colour);
    const corners = [[length, -height], [0, -height], [0, height], [length, height]];
    this.line(corners.map(([dx, dy]) => [from + dx, y + dy]), width, colour);
    this.line([[piston, y - 0.75 * height], [piston, y + 0.75 * height]], 1.6 * width, colour);
    this.line([[piston, y], [b, y]], width, colour);
  },

  // The part of its stroke at which a damper is, from its length in pixels.
  stroke({ low, high }, length) {
    return high > low ? Math.min(1, Math.max(0, (length / this.view.scale - low) / (high - low))) : 0.5;
  },

  draw_spring(shape, [p, q]) {
    this.along(p, q, (length) => this.zigzag(0, length, 0, 0.55 * this.U, shape.mean));
  },

  draw_damper(shape, [p, q]) {
    this.along(p, q, (length) => this.dashpot(0, length, 0, 0.45 * this.U, this.stroke(shape, length)));
  },

  draw_spring_damper(shape, [p, q]) {
    this.along(p, q, (length) => {
      const y = 0.7 * this.U;
      const lead = Math.min(0.7 * this.U, 0.12 * length);
      for (const [from, to] of [[0, lead], [length, length - lead]]) {
        this.line([[from, 0], [to, 0]], 1.3 * this.thin, this.theme.force);
        this.line([[to, -y], [to, y]], 1.3 * this.thin, this.theme.force);
      }
      this.zigzag(lead, length - lead, -y, 0.42 * this.U, shape.mean);
      this.dashpot(lead, length - lead, y, 0.36 * this.U, this.stroke(shape, length));
    });
  },

  draw_actuator(shape, [p, q]) {
    this.along(p, q, (length) => {
      const body = Math.min(0.6 * length, Math.max(0.35 * length, 4 * this.U));
      this.line([[0, 0], [body, 0]], 0.8 * this.U, this.theme.rod);
      this.line([[body, 0], [length, 0]], 0.35 * this.U, this.theme.drive);
    });
  },

  // From the angle of frame_a to that of frame_b.
  draw_spiral(shape, [b, a]) {
    const { U } = this;
    const turns = 2 * TAU + Math.max(-TAU, Math.min(2 * TAU, b[2] - a[2]));
    const points = [];
    for (let k = 0; k <= 60; k += 1) {
      const angle = a[2] + (turns * k) / 60;
      const radius = U * (1.55 - (1.15 * k) / 60);
      points.push([b[0] + radius * Math.cos(angle), b[1] - radius * Math.sin(angle)]);
    }
    this.line(points, 1.2 * this.thin, this.theme.force);
  },

  draw_bushing(shape, [b, a]) {
    this.circle(a[0], a[1], 0.85 * this.U, mixed(this.theme.force, this.theme.paper, 0.7), this.theme.force);
    this.circle(b[0], b[1], 0.3 * this.U, this.theme.paper);
    this.line([a, b], this.thin, this.theme.force);
  },

  draw_turning(shape, [p]) {
    const { U } = this;
    const radius = 1.75 * U;
    this.at(p, (g) => {
      g.beginPath();
      g.arc(0, 0, radius, 0.35, -2.6, true);
      g.lineWidth = 1.8 * this.thin;
      g.strokeStyle = this.theme.drive;
      g.stroke();
      this.head([radius * Math.cos(2.6), -radius * Math.sin(2.6), 2.6 + Math.PI / 2], this.theme.drive);
    });
  },

  draw_pushing(shape, [p, axis]) {
    const { U } = this;
    this.at([p[0], p[1], axis[2]], () => {
      this.line([[-1.1 * U, -1.4 * U], [0.9 * U, -1.4 * U]], 1.8 * this.thin, this.theme.drive);
      this.head([1.2 * U, -1.4 * U, 0], this.theme.drive);
    });
  },

  // The head of an arrow, its point at a place.
  head(place, colour, size = 0.75 * this.U) {
    this.at(place, (g) => {
      g.beginPath();
      g.moveTo(0.4 * size, 0);
      g.lineTo(-0.6 * size, 0.45 * size);
      g.lineTo(-0.6 * size, -0.45 * size);
      g.closePath();
      g.fillStyle = colour;
      g.fill();
    });
  },

  // An arrow from p by (fx, fy) pixels, fy up.
  arrow(p, fx, fy, colour) {
    const length = Math.hypot(fx, fy);
    if (length < 2) return;
    const size = Math.min(9, 0.6 * length);
    const angle = Math.atan2(fy, fx);
    const end = [p[0] + fx, p[1] - fy];
    this.line([p, [end[0] - 0.5 * size * Math.cos(angle), end[1] + 0.5 * size * Math.sin(angle)]], 2, colour);
    this.head([end[0] - 0.4 * size * Math.cos(angle), end[1] + 0.4 * size * Math.sin(angle), angle], colour, size);
  },

  // An arc about p, counter-clockwise for positive values; `part` is its size, 1 the largest of the motion.
  turningArrow(p, part, colour) {
    if (Math.abs(part) < 0.01) return;
    const radius = 1.6 * this.U + 6;
    const angle = 4.7 * part;
    this.g.beginPath();
    this.g.arc(p[0], p[1], radius, 0, -angle, angle > 0);
    this.g.lineWidth = 2;
    this.g.strokeStyle = colour;
    this.g.stroke();
    const end = [p[0] + radius * Math.cos(angle), p[1] - radius * Math.sin(angle)];
    this.head([...end, angle + (Math.sign(angle) * Math.PI) / 2], colour, 9);
  },
});
