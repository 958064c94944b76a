// The state of the page: its time, its theme, and what it shows.
const data = JSON.parse($("data").textContent);
const Motion = data.axes ? SpaceMotion : PlaneMotion;
const motion = data.modes ? new (vibrating(Motion))(data) : new Motion(data);
const ghost = data.ghost && new Motion(data.ghost);
const canvas = $("picture");
const show = { labels: false, masses: false, frames: false, forces: false, reactions: false, deflection: 1, size: 1 };
const { events } = data; // [time, text] of each mark
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
  theme.bodies.forEach((colour, k) => (theme[`s${k}`] = colour));
  for (const name of ["ink", "pale", "paper", "shade", "grid", "force", "drive", "rod", "hot", "load", "reaction"])
    theme[name] = of(name);
  theme.name = theme.ink;
  redraw();
}

function isDark() {
  const set = document.documentElement.dataset.theme;
  return set ? set === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
}

function redraw() {
  if (due) return;
  due = true;
  requestAnimationFrame(paint);
}

// The picture, on the canvas that has its marks; the plots and the state.
function paint() {
  due = false;
  if (!theme) return;
  const ratio = devicePixelRatio || 1;
  const [width, height] = [canvas.clientWidth, canvas.clientHeight];
  if (surface.width !== Math.round(width * ratio) || surface.height !== Math.round(height * ratio)) {
    [surface.width, surface.height] = [Math.round(width * ratio), Math.round(height * ratio)];
    painter.resize(width, height, ratio);
  }
  const g = surface.getContext("2d");
  g.setTransform(ratio, 0, 0, ratio, 0, 0);
  g.clearRect(0, 0, width, height);
  g.lineCap = g.lineJoin = "round";
  letters(g);
  paintPicture(g, width, height);
  plots.paint(theme);
  report();
}

// The state as text and as data of the page.
function report() {
  const digits = Math.max(3, Math.ceil(3 - Math.log10(last - first || 1)));
  const seconds = () => `t = ${motion.time.toFixed(Math.min(9, digits))} s`;
  $("status").textContent = data.modes ? `phase ${Math.round(360 * motion.time)}°` : seconds();
  Object.assign($("status").dataset, { time: motion.time, frame: motion.row, playing });
  Object.assign(canvas.dataset, viewState());
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
    added(row, "th", { scope: "row", textContent: entries[body.rows.length - 1][0] });
    for (let k = 0; k < Motion.columns.length; k += 1) row.insertCell();
  }
  entries.forEach(([, at], k) => {
    const pose = motion.pose(at).map((value) => (Math.abs(value) < 1e-15 * data.unit ? 0 : value));
    pose.forEach((value, j) => {
      body.rows[k].cells[j + 1].textContent = written(value + (data.origin[j] || 0), 6);
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
