// Marks on a picture: texts, its scale, centres of mass.
const AXIS = 18; // length of the axes of a frame [px]
const CORNER = 14; // distance of the scale bar from the edges of the picture [px]

function letters(g) {
  g.font = "12px system-ui, 'DejaVu Sans', sans-serif";
  g.textAlign = "left";
  g.textBaseline = "middle";
}

function text(g, words, x, y, colour = theme.ink) {
  g.strokeStyle = theme.paper;
  g.lineWidth = 4;
  g.strokeText(words, x, y);
  g.fillStyle = colour;
  g.fillText(words, x, y);
}

function polyline(g, points, width, colour) {
  g.beginPath();
  points.forEach(([x, y], k) => (k ? g.lineTo(x, y) : g.moveTo(x, y)));
  g.lineWidth = width;
  g.strokeStyle = colour;
  g.stroke();
}

function disc(g, x, y, radius, colour) {
  g.beginPath();
  g.arc(x, y, radius, 0, 2 * Math.PI);
  g.fillStyle = colour;
  g.fill();
}

// The mark of a centre of mass.
function quartered(g, [x, y, phi], radius) {
  g.save();
  g.translate(x, y);
  g.rotate(-phi);
  disc(g, 0, 0, radius, theme.paper);
  g.lineWidth = 1;
  g.strokeStyle = g.fillStyle = theme.ink;
  g.stroke();
  for (const from of [0, Math.PI]) {
    g.beginPath();
    g.moveTo(0, 0);
    g.arc(0, 0, radius, from, from + Math.PI / 2);
    g.fill();
  }
  g.restore();
}

// A bar of a round length in the lower left corner; `scale` is the number of pixels of a metre.
function scaleBar(g, scale) {
  const wanted = Math.min(120, 0.25 * canvas.clientWidth) / scale;
  const power = 10 ** Math.floor(Math.log10(wanted));
  const length = [5, 2, 1].map((k) => k * power).find((l) => l <= wanted) || power;
  const [x, y] = [CORNER, canvas.clientHeight - CORNER];
  const end = x + length * scale;
  polyline(g, [[x, y - 4], [x, y], [end, y], [end, y - 4]], 1.2, theme.pale);
  text(g, inUnits(length), end + 7, y - 3, theme.pale);
}

function inUnits(length) {
  const units = [["km", 1e3], ["m", 1], ["mm", 1e-3], ["µm", 1e-6]];
  const [unit, size] = units.find(([, s]) => length >= (1 - 1e-9) * s) || units[3];
  return `${written(length / size, 3)} ${unit}`;
}

// Names and centres of mass of bodies; `away` is the place of a name.
function paintBodies(g, radius, away) {
  for (const [name, at] of Object.entries(data.bodies)) {
    const [x, y, phi] = painter.place(at);
    if (show.masses && !data.elastic.includes(name)) quartered(g, [x, y, data.axes ? 0 : phi], radius);
    if (show.labels) text(g, name, x + away[0], y + away[1]);
  }
}

// The axes of frames, in the colours of those of the world.
function paintFrames(g) {
  if (!show.frames) return;
  for (const at of Object.values(data.points)) {
    const [origin, ...tips] = painter.axes(at);
    tips.forEach((tip, k) => polyline(g, [origin, tip], 1.6, theme.bodies[[1, 2, 0][k]]));
  }
}

// The present ends of paths.
function paintTips(g) {
  [...traces.keys()].forEach((name, k) => {
    disc(g, ...painter.place(data.points[name]).slice(0, 2), 3, theme.bodies[k % theme.bodies.length]);
  });
}

// -- arrows ------------------------------------------------------------------------------------------------------------
function colourOf(vector) {
  return vector.group === "forces" ? theme.load : theme.reaction;
}

// The components of an arrow at the motion's time.
function valuesOf({ size, values }) {
  const { row, next, share } = motion;
  return Array.from({ length: size }, (_, d) => {
    const [a, b] = [values[size * row + d], values[size * next + d]];
    return a + (b - a) * share;
  });
}

// -- notes -------------------------------------------------------------------------------------------------------------
// Lines above the scale bar, each a text or [text, colour]; the place of the next one.
function writeNotes(g) {
  const [x, y] = [CORNER, canvas.clientHeight - CORNER - 22];
  const notes = noted();
  notes.forEach((note, k) => text(g, [note].flat()[0], x, y - 17 * k, [note].flat()[1] || theme.pale));
  return [x, y - 17 * notes.length];
}

function noted() {
  const notes = [];
  const units = { force: "N", torque: "N m" };
  for (const group of ["forces", "reactions"])
    for (const [kind, unit] of Object.entries(units)) {
      const most = data.largest[`${group} ${kind}`];
      const word = group === "forces" ? kind : { force: "reaction", torque: "reaction (torque)" }[kind];
      const words = `longest arrow of a ${word}: ${written(most || 0, 3)} ${unit}`;
      // in the plane all torques have arcs of one size
      if (show[group] && most && (data.axes || kind === "force")) notes.push([words, colourOf({ group })]);
    }
  for (const [time, words] of events)
    if (Math.abs(time - motion.time) <= 1e-9 * (last - first)) notes.push([words, theme.drive]);
  if (show.deflection !== 1) notes.push(`deflection × ${show.deflection}`);
  if (painter.step && show.ground) notes.push(`grid ${inUnits(painter.step)}`);
  if (data.pale) notes.push(`pale: ${data.pale}`);
  if (data.modes) notes.push(...modeNotes());
  return notes;
}
