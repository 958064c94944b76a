// Gears, cams, rings, belts and ropes; further methods of Painter. The same as gear_pictures.py.
Object.assign(Painter.prototype, {
  outline(points) {
    const k = this.view.scale;
    this.g.beginPath();
    points.forEach(([x, y], i) => this.g[i ? "lineTo" : "moveTo"](k * x, -k * y));
    this.g.closePath();
  },

  draw_plate(shape, [p]) {
    const colour = this.colour(this.owners.get(shape.at[0][0]));
    this.at(p, () => {
      this.outline(shape.points);
      this.area(mixed(colour, this.theme.paper, 0.78), colour);
      if (shape.bare) return;
      const [x, y] = shape.points[0].map((value) => value * this.view.scale);
      this.line([[0, 0], [x, -y]], this.thin, mixed(colour, this.theme.paper, 0.3));
    });
    if (!shape.bare) this.circle(p[0], p[1], Math.max(2, 0.3 * this.U), this.theme.paper);
  },

  draw_ring(shape, [p]) {
    const colour = this.colour(this.owners.get(shape.at[0][0]));
    const fill = mixed(colour, this.theme.paper, 0.78);
    this.circle(p[0], p[1], shape.radius * this.view.scale, fill, colour, 1.5);
    this.at(p, () => {
      this.outline(shape.points);
      this.area(this.theme.paper, colour);
    });
  },

  // The strands between the points of contact, and the arcs on the far sides.
  draw_belt(shape, [p, q]) {
    this.along(p, q, (length) => {
      const [ra, rb] = [shape.r_a * this.view.scale, shape.r_b * this.view.scale];
      if (length <= Math.abs(ra - rb)) return;
      const lean = Math.acos((ra - rb) / length);
      const half = rb > 0 ? lean : Math.PI - lean;
      const width = Math.max(2, 0.2 * this.U);
      for (const side of [1, -1]) {
        const [x, y] = [Math.cos(lean), side * Math.sin(lean)];
        this.line([[ra * x, ra * y], [length + rb * x, rb * y]], width, this.theme.force);
      }
      for (const [centre, radius, first, last] of [[0, ra, lean, TAU - lean], [length, Math.abs(rb), -half, half]]) {
        this.g.beginPath();
        this.g.arc(centre, 0, radius, first, last);
        this.g.lineWidth = width;
        this.g.strokeStyle = this.theme.force;
        this.g.stroke();
      }
    });
  },

  // A parabola through its middle.
  draw_rope(shape, [p, q, m]) {
    const [x, y] = m ? [2 * m[0] - (p[0] + q[0]) / 2, 2 * m[1] - (p[1] + q[1]) / 2] : q;
    this.g.beginPath();
    this.g.moveTo(p[0], p[1]);
    this.g.quadraticCurveTo(x, y, q[0], q[1]);
    this.g.lineWidth = Math.max(1.5, 0.14 * this.U);
    this.g.strokeStyle = this.theme.force;
    this.g.stroke();
  },
});
