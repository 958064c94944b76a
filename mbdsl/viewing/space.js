// Bodies in space, projected; further methods of Painter. The same as in picture.py.
Object.assign(Painter.prototype, {
  draw_bar(shape, [p, q]) {
    this.line([p, q], Math.max(3, 0.5 * this.U), this.colour(shape.name));
  },

  draw_disc(shape, points) {
    const { g } = this;
    const colour = this.colour(shape.name);
    g.beginPath();
    points.forEach(([x, y], k) => g[k ? "lineTo" : "moveTo"](x, y));
    g.closePath();
    this.area(mixed(colour, this.theme.paper, 0.78), colour);
  },
});
