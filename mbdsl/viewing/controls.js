// Controls of the page: buttons, lists, keys.
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
  const label = added(list, "label", { className: "check" });
  const box = added(label, "input", { type: "checkbox", checked: on });
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
  const headings = $("values").querySelector("thead tr");
  for (const words of Motion.columns) added(headings, "th", { scope: "col", textContent: words });
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
    added($("about"), "dt", { textContent: key });
    added($("about"), "dd", { textContent: value });
  }
  for (const name of data.traced) trace(name, true);
  for (const group of data.arrows || []) if (vectors.some((v) => v.group === group)) option(group, true);
  plots.build();
  fillEvents();
}

// A mark below the time line at each event, inset by half the width of its knob.
function fillEvents() {
  document.body.classList.toggle("with-events", events.length > 0);
  for (const [time, words] of events) {
    const mark = added($("line"), "i", { title: `${words}, t = ${written(time, 6)} s` });
    const part = (time - first) / (last - first || 1);
    mark.style.left = `calc(8px + ${part} * (100% - 16px))`;
    mark.addEventListener("click", () => (play(false), seek(time)));
  }
}

function nextEvent(by) {
  const near = 1e-9 * (last - first);
  const found = events.map(([time]) => time).filter((time) => by * (time - motion.time) > near);
  if (found.length) (play(false), seek(by > 0 ? found[0] : found[found.length - 1]));
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
  ArrowUp: () => drag(0, 40),
  ArrowDown: () => drag(0, -40),
  Home: () => (play(false), seek(first)),
  End: () => (play(false), seek(last)),
  "[": () => pick($("speed"), -1),
  "]": () => pick($("speed"), 1),
  e: (event) => nextEvent(event.shiftKey ? -1 : 1),
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
