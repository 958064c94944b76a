// Marks on a picture: texts, its scale, centres of mass.
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

// The mark of a centre of mass.
function quartered(g, [x, y, phi], radius) {
  g.save();
  g.translate(x, y);
  g.rotate(-phi);
  g.beginPath();
  g.arc(0, 0, radius, 0, 2 * Math.PI);
  g.fillStyle = theme.paper;
  g.fill();
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

// Lines above the scale bar, each a text or [text, colour]; the place of the next one.
function writeNotes(g, notes) {
  const [x, y] = [CORNER, canvas.clientHeight - CORNER - 22];
  notes.forEach((note, k) => text(g, [note].flat()[0], x, y - 17 * k, [note].flat()[1] || theme.pale));
  return [x, y - 17 * notes.length];
}
