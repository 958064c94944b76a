// Signals over time, one chart for each unit, with a cursor at the motion's time.

function ticks(low, high, most) {
  const span = high - low || Math.abs(high) || 1;
  const power = 10 ** Math.floor(Math.log10(span / most));
  const step = [1, 2, 5, 10].map((k) => k * power).find((s) => span / s <= most);
  const found = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * span; k += 1) found.push(k * step);
  return found;
}

function write(g, words, x, y, align, baseline) {
  Object.assign(g, { font: "11px system-ui, 'DejaVu Sans', sans-serif", fillStyle: theme.pale });
  Object.assign(g, { textAlign: align, textBaseline: baseline });
  g.fillText(words, x, y);
}

function written(value, digits = 4) {
  if (!Number.isFinite(value)) return "–";
  const size = Math.abs(value);
  const small = size !== 0 && (size < 1e-4 || size >= 1e6);
  const decimals = Math.max(0, digits - 1 - Math.floor(Math.log10(size || 1)));
  const text = small ? value.toExponential(Math.max(1, digits - 2)) : value.toFixed(Math.min(12, decimals));
  return text.replace(/(\.\d*?)0+(e|$)/, "$1$2").replace(/\.(e|$)/, "$1").replace("e+", "e").replaceAll("-", "−");
}

// Values from integers, of which the lowest stands for no value.
function levels({ y, low, high }) {
  return Float64Array.from(decoded(y), (k) => (k === -32768 ? NaN : low + ((k / 32767 + 1) / 2) * (high - low)));
}

class Plots {
  // `look` is the time below the pointer, whose values are shown in place of those of the motion's time.
  constructor(box, data, motion, seek, redraw) {
    Object.assign(this, { box, data, motion, seek, redraw, charts: [], look: null });
    this.signals = data.signals.map((s) => ({ ...s, y: levels(s) }));
    this.times = data.times ? decoded(data.times) : motion.t;
    this.jumps = data.events.map(([t]) => t);
    this.shown = new Set(data.shown);
  }

  value(signal, time) {
    const { y } = signal;
    const [row, part] = between(this.times, time);
    const [a, b] = [y[row], y[Math.min(row + 1, y.length - 1)]];
    const jump = this.jump(signal, row + 1);
    return jump === null ? a + (b - a) * part : time < jump ? a : b;
  }

  // The time of a jump before point i, that of the event, if there is one: as in curves.py.
  jump({ y, held }, i) {
    if (i < 1 || i >= y.length || y[i - 1] === y[i]) return null;
    if (!held && (y[i - 2] !== y[i - 1] || y[i] !== y[i + 1])) return null;
    const [from, to] = [this.times[i - 1], this.times[i]];
    const last = this.jumps[between(this.jumps, to)[0]];
    return last > from && last <= to ? last : to;
  }

  toggle(name, on) {
    on ? this.shown.add(name) : this.shown.delete(name);
    this.build();
  }

  build() {
    this.box.replaceChildren();
    const groups = new Map();
    for (const name of this.shown) {
      const signal = this.signals.find((s) => s.name === name);
      if (!groups.has(signal.unit)) groups.set(signal.unit, []);
      groups.get(signal.unit).push(signal);
    }
    this.charts = [...groups].map(([unit, signals]) => this.chart(unit, signals));
  }

  chart(unit, signals) {
    const figure = added(this.box, "figure");
    const canvas = added(figure, "canvas");
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", `${signals.map((s) => s.name).join(", ")} ${unit ? `in ${unit} ` : ""}over time`);
    const list = added(figure, "ul");
    const entries = signals.map((signal, k) => {
      const item = added(list, "li", { title: signal.doc || "" });
      added(item, "i", { className: `s${k % 8}` });
      added(item, "span", { textContent: signal.name });
      return added(item, "span", { className: "value" });
    });
    const all = signals.flatMap((s) => [s.low, s.high]).filter(Number.isFinite);
    let [low, high] = all.length ? [Math.min(...all), Math.max(...all)] : [0, 1];
    if (high - low < 1e-12 * Math.max(Math.abs(high), Math.abs(low)) || high === low)
      [low, high] = [low - 0.5 * (Math.abs(low) || 1), high + 0.5 * (Math.abs(high) || 1)];
    const chart = { unit, signals, canvas, entries, low, high, back: document.createElement("canvas"), key: "" };
    const time = (event) => {
      const { left, right } = chart.area;
      const part = (event.clientX - canvas.getBoundingClientRect().left - left) / (right - left);
      const [from, to] = [this.times[0], this.times[this.times.length - 1]];
      return from + Math.min(1, Math.max(0, part)) * (to - from);
    };
    const move = (event) => {
      this.look = null;
      this.seek(time(event));
    };
    const look = (t) => {
      this.look = t;
      this.redraw();
    };
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      move(event);
    });
    canvas.addEventListener("pointermove", (event) => (event.buttons ? move(event) : look(time(event))));
    canvas.addEventListener("pointerleave", () => look(null));
    return chart;
  }

  paint(theme) {
    for (const chart of this.charts) this.paintChart(chart, theme);
  }

  paintChart(chart, theme) {
    const { canvas, back } = chart;
    const ratio = devicePixelRatio || 1;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    if (!width) return;
    const key = [width, height, ratio, theme.name].join();
    if (key !== chart.key) {
      for (const c of [canvas, back]) [c.width, c.height] = [Math.round(width * ratio), Math.round(height * ratio)];
      chart.area = { left: 52, right: width - 10, top: 20, bottom: height - 20 };
      this.paintBack(chart, back.getContext("2d"), ratio, theme);
      chart.key = key;
    }
    const g = canvas.getContext("2d");
    g.setTransform(1, 0, 0, 1, 0, 0);
    g.clearRect(0, 0, canvas.width, canvas.height);
    g.drawImage(back, 0, 0);
    g.setTransform(ratio, 0, 0, ratio, 0, 0);
    const time = this.look ?? this.motion.time;
    const [x, y] = this.scales(chart);
    const { left, right, top, bottom } = chart.area;
    for (const [t, colour] of [[this.motion.time, theme.ink], [this.look, theme.pale]])
      if (t !== null) polyline(g, [[x(t), top], [x(t), bottom]], 1, colour);
    const words = this.look === null ? "" : `t = ${written(time)} s`;
    write(g, words, (left + right) / 2, top - 8, "center", "alphabetic");
    chart.signals.forEach((signal, k) => {
      const value = this.value(signal, time);
      chart.entries[k].textContent = `${written(value)} ${signal.unit}`;
      if (!Number.isFinite(value)) return;
      disc(g, x(time), y(value), 3.5, theme.bodies[k % theme.bodies.length]);
    });
  }

  scales({ area, low, high }) {
    const [from, to] = [this.times[0], this.times[this.times.length - 1]];
    const pad = 0.04 * (high - low);
    return [
      (t) => area.left + ((t - from) / (to - from || 1)) * (area.right - area.left),
      (v) => area.bottom - ((v - low + pad) / (high - low + 2 * pad)) * (area.bottom - area.top),
    ];
  }

  paintBack(chart, g, ratio, theme) {
    g.setTransform(ratio, 0, 0, ratio, 0, 0);
    const { area, signals, low, high } = chart;
    const [x, y] = this.scales(chart);
    const { left, right, bottom } = area;
    for (const v of ticks(low, high, 4)) {
      polyline(g, [[left, y(v)], [right, y(v)]], 1, theme.grid);
      write(g, written(v, 3), left - 6, y(v), "right", "middle");
    }
    const [from, to] = [this.times[0], this.times[this.times.length - 1]];
    for (const t of ticks(from, to, Math.max(2, Math.floor((right - left) / 60))))
      write(g, written(t, 4), Math.min(x(t), right - 8), bottom + 5, "center", "top");
    write(g, chart.unit ? `[${chart.unit}]` : "", 4, 2, "left", "top");
    write(g, "time [s]", right, 2, "right", "top");
    for (const [t] of events) if (t >= from && t <= to) polyline(g, [[x(t), bottom - 6], [x(t), bottom]], 1, theme.pale);
    g.lineJoin = "round";
    g.lineWidth = 1.6;
    signals.forEach((signal, k) => {
      g.strokeStyle = theme.bodies[k % theme.bodies.length];
      g.setLineDash(k >= theme.bodies.length ? [5, 3] : []);
      g.beginPath();
      let down = false;
      for (let i = 0; i < signal.y.length; i += 1) {
        const ok = Number.isFinite(signal.y[i]);
        const jump = this.jump(signal, i);
        if (jump !== null) for (const k of [i - 1, i]) g.lineTo(x(jump), y(signal.y[k]));
        if (ok) g[down ? "lineTo" : "moveTo"](x(this.times[i]), y(signal.y[i]));
        down = ok;
      }
      g.stroke();
    });
    g.setLineDash([]);
  }
}
