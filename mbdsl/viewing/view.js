// The picture of a model in the plane: its view, and what is painted into it.
const painter = new Painter(data, motion);
const ghostPainter = ghost && new Painter(data.ghost, ghost);
const layer = ghost && document.createElement("canvas");
const view = { x: 0, y: 0, scale: 1, side: 400 }; // `side` is the shorter of the picture

// -- view ------------------------------------------------------------------------------------------------------------
function fit() {
  const [x0, y0, x1, y1] = data.bounds;
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
  const [x, y] = motion.point(follow, 0, 0);
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
function paint() {
  due = false;
  if (!theme) return;
  const ratio = devicePixelRatio || 1;
  const [width, height] = [canvas.clientWidth, canvas.clientHeight];
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio))
    [canvas.width, canvas.height] = [Math.round(width * ratio), Math.round(height * ratio)];
  view.side = Math.min(width, height);
  centre();
  const g = canvas.getContext("2d");
  g.setTransform(ratio, 0, 0, ratio, 0, 0);
  g.fillStyle = theme.paper;
  g.fillRect(0, 0, width, height);
  if (ghost) paintGhost(g);
  painter.paint(g, view, theme, show);
  paintTraces(g);
  paintVectors(g);
  paintMarks(g);
  plots.paint(theme);
  report();
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
  let k = 0;
  for (const [name, path] of traces) {
    g.strokeStyle = theme.bodies[k % theme.bodies.length];
    k += 1;
    for (const [alpha, end] of [[0.3, path.length], [1, motion.row + 1]]) {
      g.globalAlpha = alpha;
      g.lineWidth = 1.6;
      g.beginPath();
      for (let i = 0; i < end; i += 1) g.lineTo(view.x + view.scale * path[i][0], view.y - view.scale * path[i][1]);
      g.stroke();
    }
    g.globalAlpha = 1;
    const [x, y] = painter.place(data.points[name]);
    g.fillStyle = g.strokeStyle;
    g.beginPath();
    g.arc(x, y, 3, 0, 2 * Math.PI);
    g.fill();
  }
}

function paintVectors(g) {
  const longest = 0.22 * Math.min(canvas.clientWidth, canvas.clientHeight) * show.size;
  for (const vector of vectors) {
    if (!show[vector.group]) continue;
    const colour = vector.group === "forces" ? theme.load : theme.reaction;
    const place = painter.place(vector.at);
    const at = (j) => {
      const n = vector.size;
      const [a, b] = [vector.values[n * motion.row + j], vector.values[n * motion.next + j]];
      return (a + (b - a) * motion.share) / (data.largest[`${vector.group}${n}`] || 1);
    };
    if (vector.size === 2) painter.arrow(place, at(0) * longest, at(1) * longest, colour);
    else painter.turningArrow(place, at(0), colour);
  }
}

function paintMarks(g) {
  letters(g);
  if (show.frames) {
    for (const at of Object.values(data.points)) {
      painter.at(painter.place(at), () => {
        painter.line([[0, 0], [18, 0]], 1.6, theme.bodies[1]);
        painter.line([[0, 0], [0, -18]], 1.6, theme.bodies[2]);
      });
    }
  }
  if (show.masses)
    for (const [name, at] of Object.entries(data.bodies))
      if (!data.elastic.includes(name)) quartered(g, painter.place(at), Math.max(3, 0.34 * painter.U));
  if (show.labels) {
    for (const [name, at] of Object.entries(data.bodies)) {
      const [x, y] = painter.place(at);
      text(g, name, x + 0.6 * painter.U + 3, y - 0.6 * painter.U - 4);
    }
  }
  scaleBar(g, view.scale);
  paintNotes(g);
}

// The notes above the scale bar, and the colours of beams above them.
function paintNotes(g) {
  const notes = [];
  const both = show.forces && show.reactions && data.largest.forces2 === data.largest.reactions2;
  if (both && data.largest.forces2)
    notes.push(
      `longest arrow: ${written(data.largest.forces2, 3)} N`,
      ["reactions", theme.reaction],
      ["forces", theme.load],
    );
  else for (const [group, name] of [["forces", "force"], ["reactions", "reaction"]])
    if (show[group] && data.largest[`${group}2`])
      notes.push(`longest arrow of a ${name}: ${written(data.largest[`${group}2`], 3)} N`);
  if (show.deflection !== 1) notes.push(`deflection × ${show.deflection}`);
  if (data.pale) notes.push(`pale: ${data.pale}`);
  if (data.modes) notes.push(...modeNotes());
  const [x, y] = writeNotes(g, notes);
  if (data.modes ? data.curves.length : data.strain) colourBar(g, x, y - 4);
}

// The colour bar of bending strain.
function colourBar(g, x, y) {
  const [width, height] = [90, 8];
  const own = painter.colour(data.elastic[0]);
  const shades = g.createLinearGradient(x, 0, x + width, 0);
  shades.addColorStop(0, mixed(own, theme.paper, 0.72));
  shades.addColorStop(1, theme.hot);
  g.fillStyle = shades;
  g.fillRect(x, y, width, height);
  g.lineWidth = 1;
  g.strokeStyle = theme.pale;
  g.strokeRect(x, y, width, height);
  const words = data.modes ? "bending strain, relative" : `bending strain 0 … ${written(data.strain, 3)}`;
  text(g, words, x + width + 8, y + height / 2, theme.pale);
}
