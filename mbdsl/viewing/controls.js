// What the user does: buttons, lists, keys, pointers; and the start of the page.
function speeds() {
  if (data.modes) {
    for (const speed of [0.1, 0.2, 0.5, 1, 2, 5])
      $("speed").add(new Option(`${speed} cycles/s`, speed, false, speed === 0.5));
    return;
  }
  const wanted = last - first >= 1 && last - first <= 40 ? 1 : (last - first) / 8 || 1;
  const found = [];
  const [low, high] = [Math.min(-2, Math.floor(Math.log10(wanted))), Math.max(1, Math.ceil(Math.log10(wanted)))];
  for (let power = low; power <= high; power += 1)
    for (const k of [1, 2, 5]) found.push(Number((k * 10 ** power).toPrecision(1)));
  const near = found.reduce((a, b) => (Math.abs(Math.log(b / wanted)) < Math.abs(Math.log(a / wanted)) ? b : a), 1);
  for (const speed of found.filter((s) => s <= 10 || s <= 2 * near))
    $("speed").add(new Option(speed === 1 ? "1 (real time)" : `${speed}`, speed, false, speed === near));
}

function pick(select, by) {
  const { options } = select;
  select.selectedIndex = Math.min(options.length - 1, Math.max(0, select.selectedIndex + by));
}

function check(list, name, on, change) {
  const label = list.appendChild(document.createElement("label"));
  label.className = "check";
  const box = label.appendChild(document.createElement("input"));
  box.type = "checkbox";
  box.checked = on;
  box.dataset.name = name;
  label.append(` ${name}`);
  box.addEventListener("change", () => change(box.checked));
}

function trace(name, on) {
  on ? traces.set(name, motion.path(data.points[name])) : traces.delete(name);
  for (const box of $("points").querySelectorAll("input")) if (box.dataset.name === name) box.checked = on;
  redraw();
}

function followBody(name) {
  follow = name && data.bodies[name] ? data.bodies[name][0] : null;
  $("follow").value = name;
  redraw();
}

function option(id, value) {
  show[id] = value;
  $(id).checked = value;
  redraw();
}

function switchTheme() {
  document.documentElement.dataset.theme = isDark() ? "light" : "dark";
  readTheme();
}

function fill() {
  document.querySelector("h1").textContent = data.name;
  $("doc").textContent = data.doc;
  $("mark").textContent = data.mark || "";
  $("mark").hidden = !data.mark;
  const names = Object.keys(data.bodies);
  const listed = `${names.slice(0, 12).join(", ")}${names.length > 12 ? " and more" : ""}`;
  canvas.setAttribute("aria-label", `Picture of ${data.name}: ${listed}`);
  speeds();
  if (data.modes) fillModes();
  if (last === first) {
    document.body.classList.add("still");
    $("values").open = true;
  }
  $("signals").parentElement.hidden = !plots.signals.length;
  for (const s of plots.signals) check($("signals"), s.name, plots.shown.has(s.name), (on) => {
    plots.toggle(s.name, on);
    redraw();
  });
  for (const [name, at] of Object.entries(data.points))
    if (at[0] >= 0) check($("points"), name, false, (on) => trace(name, on));
  for (const name of names) $("follow").add(new Option(name, name));
  for (const group of ["forces", "reactions"]) $(`${group}-of`).hidden = !vectors.some((v) => v.group === group);
  $("size-of").hidden = !vectors.length;
  $("deflection-of").hidden = !data.curves.length;
  for (const k of [1, 2, 5, 10, 20, 50, 100, 1000]) $("deflection").add(new Option(`× ${k}`, k));
  for (const [key, value] of data.about) {
    $("about").appendChild(document.createElement("dt")).textContent = key;
    $("about").appendChild(document.createElement("dd")).textContent = value;
  }
  for (const name of data.traced) trace(name, true);
  for (const group of data.arrows || []) if (vectors.some((v) => v.group === group)) option(group, true);
  plots.build();
}

function bind() {
  const on = (id, event, act) => $(id).addEventListener(event, act);
  on("play", "click", () => play(!playing));
  on("back", "click", () => step(-1));
  on("forth", "click", () => step(1));
  on("fit", "click", fit);
  on("closer", "click", () => zoom(1.3));
  on("further", "click", () => zoom(1 / 1.3));
  on("theme", "click", switchTheme);
  on("help", "click", () => $("keys").showModal());
  on("time", "input", () => {
    play(false);
    seek(first + (Number($("time").value) / 1e6) * (last - first));
  });
  for (const id of ["labels", "masses", "frames", "forces", "reactions"])
    on(id, "change", () => option(id, $(id).checked));
  on("follow", "change", () => followBody($("follow").value));
  on("deflection", "change", () => option("deflection", Number($("deflection").value)));
  on("size", "input", () => option("size", 10 ** (Number($("size").value) / 2)));
  on("values", "toggle", redraw);
  new ResizeObserver(() => (fitted ? fit() : redraw())).observe(canvas);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", readTheme);
  addEventListener("beforeprint", () => document.documentElement.classList.add("printing") || (readTheme(), paint()));
  addEventListener("afterprint", () => document.documentElement.classList.remove("printing") || readTheme());
}

const KEYS = {
  " ": () => play(!playing),
  ArrowLeft: (event) => step(event.shiftKey ? -10 : -1),
  ArrowRight: (event) => step(event.shiftKey ? 10 : 1),
  ArrowUp: () => ((view.y += 40), (fitted = false), redraw()),
  ArrowDown: () => ((view.y -= 40), (fitted = false), redraw()),
  Home: () => (play(false), seek(first)),
  End: () => (play(false), seek(last)),
  "[": () => pick($("speed"), -1),
  "]": () => pick($("speed"), 1),
  r: () => ($("speed").value = "1"),
  o: () => ($("loop").checked = !$("loop").checked),
  a: fit,
  "+": () => zoom(1.3),
  "=": () => zoom(1.3),
  "-": () => zoom(1 / 1.3),
  l: () => option("labels", !show.labels),
  m: () => option("masses", !show.masses),
  f: () => option("frames", !show.frames),
  v: () => option("forces", !show.forces),
  n: () => option("reactions", !show.reactions),
  b: () => {
    const { selectedIndex, options } = $("follow");
    pick($("follow"), selectedIndex + 1 < options.length ? 1 : -options.length);
    followBody($("follow").value);
  },
  t: () => [...traces.keys()].forEach((name) => trace(name, false)),
  d: switchTheme,
  PageUp: () => data.modes && chooseMode(motion.mode - 1),
  PageDown: () => data.modes && chooseMode(motion.mode + 1),
  "?": () => $("keys").showModal(),
};

addEventListener("keydown", (event) => {
  const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
  if (!KEYS[key] || event.ctrlKey || event.metaKey || event.altKey || $("keys").open) return;
  const on = event.target;
  const own = ["SELECT", "SUMMARY", "BUTTON"].includes(on.tagName) || on.type === "checkbox";
  if (own && key === " ") return; // these controls use the keys themselves
  if (["size", "amplitude"].includes(on.id) || (key.startsWith("Page") && !data.modes)) return;
  if (on.tagName === "SELECT" && (key.length === 1 || key.startsWith("Arrow"))) return;
  if (["ArrowUp", "ArrowDown"].includes(key) && !(event.shiftKey || on === canvas)) return;
  event.preventDefault();
  KEYS[key](event);
});

// -- pointers on the picture: drag, pinch, wheel, click ------------------------------------------------------------
const held = new Map();
let moved = 0;

function nearest(x, y, reach) {
  let found = null;
  for (const [name, at] of Object.entries(data.points)) {
    const [px, py] = painter.place(at);
    const distance = Math.hypot(px - x, py - y);
    if (distance < reach) [found, reach] = [[name, px, py, at], distance];
  }
  return found;
}

function hover(event) {
  const found = held.size ? null : nearest(event.offsetX, event.offsetY, 14);
  $("tip").hidden = !found;
  canvas.style.cursor = found ? "pointer" : "";
  if (!found) return;
  const [x, y] = motion.pose(found[3]);
  $("tip").textContent = `${found[0]}  x = ${written(x + data.origin[0])} m, y = ${written(y + data.origin[1])} m`;
  $("tip").style.left = `${Math.max(0, Math.min(found[1] + 14, canvas.clientWidth - $("tip").offsetWidth - 4))}px`;
  $("tip").style.top = `${Math.max(0, found[2] - 34)}px`;
}

canvas.addEventListener("pointerdown", (event) => {
  canvas.setPointerCapture(event.pointerId);
  held.set(event.pointerId, [event.offsetX, event.offsetY]);
  if (held.size === 1) moved = 0;
});
canvas.addEventListener("pointermove", (event) => {
  const from = held.get(event.pointerId);
  if (!from) return hover(event);
  const to = [event.offsetX, event.offsetY];
  const other = [...held].find(([id]) => id !== event.pointerId);
  moved += Math.hypot(to[0] - from[0], to[1] - from[1]);
  if (other) {
    const [p] = [other[1]];
    const spread = (q) => Math.max(8, Math.hypot(q[0] - p[0], q[1] - p[1]));
    zoom(spread(to) / spread(from), p[0], p[1]);
  } else if (moved > 3) {
    if (follow !== null) followBody("");
    view.x += to[0] - from[0];
    view.y += to[1] - from[1];
    fitted = false;
    redraw();
  }
  held.set(event.pointerId, to);
});
for (const end of ["pointerup", "pointercancel"]) {
  canvas.addEventListener(end, (event) => {
    held.delete(event.pointerId);
    const found = moved <= 3 && end === "pointerup" && nearest(event.offsetX, event.offsetY, 14);
    if (found && found[3][0] >= 0) trace(found[0], !traces.has(found[0]));
  });
}
canvas.addEventListener("pointerleave", () => ($("tip").hidden = true));
canvas.addEventListener("wheel", (event) => {
  event.preventDefault();
  const lines = event.deltaMode === 1 ? 20 : 1;
  zoom(Math.exp(-0.0015 * lines * Math.max(-300, Math.min(300, event.deltaY))), event.offsetX, event.offsetY);
}, { passive: false });

fill();
bind();
readTheme();
fit();
const asked = /[#&]t=([-+.\de]+)/.exec(location.hash);
if (asked) seek(Number(asked[1]));
else if (!matchMedia("(prefers-reduced-motion: reduce)").matches) play(true);
