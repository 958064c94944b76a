// The picture of a model in the plane: its view, and what is painted into it.
const painter = new Painter(data, motion);
const ghostPainter = ghost && new Painter(data.ghost, ghost);
const surface = canvas;
const layer = ghost && document.createElement("canvas");
const view = { x: 0, y: 0, scale: 1, side: 400 }; // `side` is the shorter of the picture

// -- view ------------------------------------------------------------------------------------------------------------
function fit() {
  const [[x0, y0], [x1, y1]] = data.bounds;
  const [width, height] = [canvas.clientWidth, canvas.clientHeight];
  const margin = Math.min(64, Math.max(0.12 * Math.min(width, height), Math.min(46, 0.2 * Math.min(width, height))));
  view.scale = Math.min((width - 2 * margin) / (x1 - x0 || 1e-9), (height - 2 * margin) / (y1 - y0 || 1e-9));
  if (!(view.scale < 1e8)) view.scale = 100 / data.unit;
  view.x = width / 2 - (view.scale * (x0 + x1)) / 2;
  view.y = height / 2 + (view.scale * (y0 + y1)) / 2;
  fitted = true;
  centre();
  redraw();
}

function zoom(factor, x = canvas.clientWidth / 2, y = canvas.clientHeight / 2) {
  const scale = Math.min(1e9 / data.unit, Math.max(1e-3 / data.unit, view.scale * factor));
  view.x = x + ((view.x - x) * scale) / view.scale;
  view.y = y + ((view.y - y) * scale) / view.scale;
  view.scale = scale;
  fitted = false;
  redraw();
}

// The camera of a followed body keeps its place in the picture.
function centre() {
  if (follow === null) return;
  const [x, y] = motion.point([follow]);
  view.x = canvas.clientWidth / 2 - view.scale * x;
  view.y = canvas.clientHeight / 2 + view.scale * y;
}

function drag(dx, dy) {
  if (follow !== null) followBody("");
  view.x += dx;
  view.y += dy;
  fitted = false;
  redraw();
}

function viewState() {
  return { scale: view.scale, x: view.x, y: view.y };
}

// -- picture ---------------------------------------------------------------------------------------------------------
function paintPicture(g, width, height) {
  view.side = Math.min(width, height);
  centre();
  g.fillStyle = theme.paper;
  g.fillRect(0, 0, width, height);
  if (ghost) paintGhost(g);
  painter.paint(g, view, theme, show);
  paintTraces(g);
  paintVectors(g);
  paintMarks(g);
}

// On a layer of its own, which is pale as a whole: parts that overlap are as pale as others.
function paintGhost(g) {
  ghost.seek(motion.time);
  [layer.width, layer.height] = [canvas.width, canvas.height]; // this clears it
  const own = layer.getContext("2d");
  own.setTransform(g.getTransform());
  ghostPainter.paint(own, view, theme, show);
  g.save();
  g.setTransform(1, 0, 0, 1, 0, 0);
  g.globalAlpha = 0.28;
  g.drawImage(layer, 0, 0);
  g.restore();
}

function paintTraces(g) {
  [...traces].forEach(([name, path], k) => {
    const colour = theme.bodies[k % theme.bodies.length];
    const points = path.map((p) => painter.pixel(p));
    g.globalAlpha = 0.3;
    polyline(g, points, 1.6, colour);
    g.globalAlpha = 1;
    polyline(g, points.slice(0, motion.row + 1), 1.6, colour);
  });
  paintTips(g);
}

function paintVectors(g) {
  const longest = 0.22 * Math.min(canvas.clientWidth, canvas.clientHeight) * show.size;
  for (const vector of vectors) {
    if (!show[vector.group]) continue;
    const colour = colourOf(vector);
    const place = painter.place(vector.at);
    const parts = valuesOf(vector).map((x) => x / (data.largest[vector.key] || 1));
    if (vector.kind === "force") arrow(g, place, parts[0] * longest, parts[1] * longest, colour);
    else turningArrow(g, place, parts[0], colour);
  }
}

// The head of an arrow at a point, with its angle.
function head(g, [x, y, phi], colour, size) {
  const [c, s] = [size * Math.cos(phi), size * Math.sin(phi)];
  g.beginPath();
  for (const [u, v] of [[0.4, 0], [-0.6, 0.45], [-0.6, -0.45]]) g.lineTo(x + c * u - s * v, y - s * u - c * v);
  g.fillStyle = colour;
  g.fill();
}

// An arrow from p by (fx, fy) pixels, fy up.
function arrow(g, [x, y], fx, fy, colour) {
  const length = Math.hypot(fx, fy);
  if (length < 2) return;
  const size = Math.min(9, 0.6 * length);
  const [c, s] = [fx / length, fy / length];
  const end = [x + fx, y - fy];
  polyline(g, [[x, y], [end[0] - 0.5 * size * c, end[1] + 0.5 * size * s]], 2, colour);
  head(g, [end[0] - 0.4 * size * c, end[1] + 0.4 * size * s, Math.atan2(fy, fx)], colour, size);
}

// An arc about p, counter-clockwise for positive values; `part` is its size, 1 the largest of the motion.
function turningArrow(g, [x, y], part, colour) {
  if (Math.abs(part) < 0.01) return;
  const radius = 1.6 * painter.U + 6;
  const angle = 4.7 * part;
  const on = (u) => [x + radius * Math.cos(u), y - radius * Math.sin(u)];
  polyline(g, Array.from({ length: 40 }, (_, k) => on((angle * k) / 39)), 2, colour);
  head(g, [...on(angle), angle + (Math.sign(angle) * Math.PI) / 2], colour, 9);
}

function paintMarks(g) {
  paintFrames(g);
  paintBodies(g, Math.max(3, 0.34 * painter.U), [0.6 * painter.U + 3, -0.6 * painter.U - 4]);
  scaleBar(g, view.scale);
  const [x, y] = writeNotes(g);
  if (data.modes ? data.curves.length : data.strain) colourBar(g, x, y - 4);
}

// The colour bar of bending strain.
function colourBar(g, x, y) {
  const [width, height] = [90, 8];
  const own = painter.colour(data.items.find((item) => item.curve !== undefined).stroke);
  const shades = g.createLinearGradient(x, 0, x + width, 0);
  shades.addColorStop(0, own);
  shades.addColorStop(1, theme.hot);
  g.fillStyle = shades;
  g.fillRect(x, y, width, height);
  g.lineWidth = 1;
  g.strokeStyle = theme.pale;
  g.strokeRect(x, y, width, height);
  const words = data.modes ? "bending strain, relative" : `bending strain 0 … ${written(data.strain, 3)}`;
  text(g, words, x + width + 8, y + height / 2, theme.pale);
}
