// Time, view, keys and controls of the page.
const $ = (id) => document.getElementById(id);
const data = JSON.parse($("data").textContent);
const motion = data.modes ? new Vibration(data) : new Motion(data);
const painter = new Painter(data, motion);
const ghost = data.ghost && new Motion(data.ghost);
const ghostPainter = ghost && new Painter(data.ghost, ghost);
const layer = ghost && document.createElement("canvas");
const canvas = $("picture");
const view = { x: 0, y: 0, scale: 1, side: 400 }; // `side` is the shorter of the picture
const show = { labels: false, masses: false, frames: false, forces: false, reactions: false, deflection: 1, size: 1 };
const vectors = data.vectors.map((v) => ({ ...v, values: decoded(v.values) }));
const traces = new Map(); // name of a point -> its path
const first = motion.t[0];
const last = motion.t[motion.t.length - 1];
let [playing, before, theme, follow, fitted, due] = [false, 0, null, null, true, false];
const plots = new Plots($("plots"), data, motion, seek, redraw);

// -- theme -----------------------------------------------------------------------------------------------------------
function readTheme() {
  const style = getComputedStyle(document.documentElement);
  const of = (name) => style.getPropertyValue(`--${name}`).trim();
  theme = { bodies: [0, 1, 2, 3, 4, 5, 6, 7].map((k) => of(`s${k}`)) };
  for (const name of ["ink", "pale", "paper", "shade", "grid", "force", "drive", "rod", "hot", "load", "reaction"])
    theme[name] = of(name);
  theme.name = theme.ink;
  redraw();
}

function isDark() {
  const set = document.documentElement.dataset.theme;
  return set ? set === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
}

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

// -- picture ---------------------------------------------------------------------------------------------------------
function redraw() {
  if (due) return;
  due = true;
  requestAnimationFrame(paint);
}

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

function text(g, words, x, y, colour = theme.ink) {
  g.strokeStyle = theme.paper;
  g.lineWidth = 4;
  g.strokeText(words, x, y);
  g.fillStyle = colour;
  g.fillText(words, x, y);
}

function paintMarks(g) {
  g.font = "12px system-ui, 'DejaVu Sans', sans-serif";
  g.textAlign = "left";
  g.textBaseline = "middle";
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
      if (!data.elastic.includes(name)) painter.centre(painter.place(at));
  if (show.labels) {
    for (const [name, at] of Object.entries(data.bodies)) {
      const [x, y] = painter.place(at);
      text(g, name, x + 0.6 * painter.U + 3, y - 0.6 * painter.U - 4);
    }
  }
  scaleBar(g);
}

function scaleBar(g) {
  const wanted = Math.min(120, 0.25 * canvas.clientWidth) / view.scale;
  const power = 10 ** Math.floor(Math.log10(wanted));
  const length = [5, 2, 1].map((k) => k * power).find((l) => l <= wanted) || power;
  const [x, y] = [14, canvas.clientHeight - 14];
  const end = x + length * view.scale;
  painter.line([[x, y - 4], [x, y], [end, y], [end, y - 4]], 1.2, theme.pale);
  const units = [["km", 1e3], ["m", 1], ["mm", 1e-3], ["µm", 1e-6]];
  const [unit, size] = units.find(([, s]) => length >= s) || units[3];
  text(g, `${written(length / size, 3)} ${unit}`, end + 7, y - 3, theme.pale);
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
  notes.forEach((note, k) => text(g, [note].flat()[0], x, y - 22 - 17 * k, [note].flat()[1] || theme.pale));
  if (data.modes ? data.curves.length : data.strain) colourBar(g, x, y - 26 - 17 * notes.length);
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

// The state as text and as data of the page.
function report() {
  const digits = Math.max(3, Math.ceil(3 - Math.log10(last - first || 1)));
  const seconds = () => `t = ${motion.time.toFixed(Math.min(9, digits))} s`;
  $("status").textContent = data.modes ? `phase ${Math.round(360 * motion.time)}°` : seconds();
  Object.assign($("status").dataset, { time: motion.time, frame: motion.row, playing });
  Object.assign(canvas.dataset, { scale: view.scale, x: view.x, y: view.y });
  $("time").value = Math.round((1e6 * (motion.time - first)) / (last - first || 1));
  const phase = `phase ${Math.round(360 * motion.time)} degrees`;
  $("time").setAttribute("aria-valuetext", data.modes ? phase : `${written(motion.time)} seconds`);
  if ($("values").open) fillPoses();
}

function fillPoses() {
  const body = $("values").querySelector("tbody");
  const entries = Object.entries(data.bodies).slice(0, 200);
  while (body.rows.length < entries.length) {
    const row = body.insertRow();
    row.appendChild(document.createElement("th")).scope = "row";
    row.cells[0].textContent = entries[body.rows.length - 1][0];
    for (let k = 0; k < 3; k += 1) row.insertCell();
  }
  entries.forEach(([, at], k) => {
    const pose = motion.pose(at).map((value) => (Math.abs(value) < 1e-15 * data.unit ? 0 : value));
    [pose[0] + data.origin[0], pose[1] + data.origin[1], pose[2]].forEach((value, j) => {
      body.rows[k].cells[j + 1].textContent = written(value, 6);
    });
  });
}

// -- time ------------------------------------------------------------------------------------------------------------
function seek(time) {
  motion.seek(time);
  redraw();
}

function step(frames) {
  play(false);
  const row = motion.row + (frames < 0 && motion.time > motion.t[motion.row] ? 1 : 0) + frames;
  seek(motion.t[Math.min(motion.t.length - 1, Math.max(0, row))]);
}

function play(on) {
  if (on && motion.time >= last) motion.seek(first);
  playing = on && last > first;
  document.documentElement.classList.toggle("playing", playing);
  $("status").setAttribute("aria-live", playing ? "off" : "polite");
  $("play").setAttribute("aria-label", playing ? "pause" : "play");
  before = 0;
  if (playing) requestAnimationFrame(advance);
  else redraw();
}

function advance(now) {
  if (!playing) return;
  const passed = before ? Math.min(0.25, (now - before) / 1000) : 0;
  before = now;
  let time = motion.time + passed * Number($("speed").value);
  if (time > last) {
    if (!$("loop").checked) {
      motion.seek(last);
      return play(false);
    }
    time = first + ((time - first) % (last - first));
  }
  motion.seek(time);
  paint();
  requestAnimationFrame(advance);
}
