// Mode shapes: poses at a phase of a mode, Re(u exp(i theta)) from the state at rest. The time of the page is the part
// of a cycle.
const vibrating = (Base) => class extends Base {
  constructor(data) {
    super(data);
    const { modes } = data;
    this.modes = modes.list;
    this.rest = Float64Array.from(this.now);
    this.t = Float64Array.from({ length: modes.phases + 1 }, (_, k) => k / modes.phases);
    this.tracks = decoded(modes.tracks);
    this.bent = modes.curves.map((c) => ({ points: decoded(c.points), bends: decoded(c.bends) }));
    this.mode = modes.first;
    this.amplitude = 1;
    this.seek(0);
  }

  // The displacement from two numbers, real and imaginary part, at index k.
  part(numbers, k) {
    return this.amplitude * (numbers[2 * k] * this.c - numbers[2 * k + 1] * this.s);
  }

  seek(time) {
    if (!this.tracks) return super.seek(time);
    this.time = Math.min(1, Math.max(0, time));
    this.row = this.next = Math.min(this.t.length - 1, Math.floor(this.time * (this.t.length - 1) + 1e-9));
    this.share = 0;
    [this.c, this.s] = [Math.cos(2 * Math.PI * this.time), Math.sin(2 * Math.PI * this.time)];
    const all = this.width * this.count;
    for (let k = 0; k < all; k += 1) this.now[k] = this.rest[k] + this.part(this.tracks, all * this.mode + k);
    if (this.normalise) for (let k = 0; k < all; k += this.width) this.normalise(k);
    return undefined;
  }

  curve(k, factor) {
    const { numbers, count, points } = this.curves[k];
    const own = this.bent[k];
    const first = count * this.mode;
    const at = (j) => numbers[j] * points.scale + this.part(own.points, 2 * first + j);
    const found = Array.from({ length: count }, (_, j) => [at(2 * j), at(2 * j + 1)]);
    const bend = (j) => own.bends[2 * (first + j)] * this.c - own.bends[2 * (first + j) + 1] * this.s;
    return { points: magnified(found, factor), colours: found.map((_, j) => Math.min(1, Math.abs(bend(j)))) };
  }

  path(at) {
    const { time } = this;
    const found = Array.from(this.t, (t) => {
      this.seek(t);
      return this.point(at);
    });
    this.seek(time);
    return found;
  }
};

function hertz(f) {
  return f >= 1e5 ? `${written(f / 1e3, 4)} kHz` : `${written(f, 4)} Hz`;
}

// A mode in words.
function about(mode) {
  if (mode.f === 0) return "moves freely";
  const state = mode.unstable ? "unstable" : mode.damped === 0 ? "does not oscillate" : "";
  const damping = mode.damping ? `damping ${written(mode.damping, 3)}` : "undamped";
  return [hertz(mode.f), damping, state].filter(Boolean).join(", ");
}

function chooseMode(k) {
  motion.mode = Math.min(motion.modes.length - 1, Math.max(0, k));
  displace();
  [...$("modes").querySelectorAll("input")].forEach((input, j) => (input.checked = j === motion.mode));
}

function setAmplitude(value) {
  motion.amplitude = value;
  displace();
}

function displace() {
  motion.seek(motion.time);
  for (const name of traces.keys()) traces.set(name, motion.path(data.points[name]));
  redraw();
}

function modeNotes() {
  const mode = motion.modes[motion.mode];
  const shown = mode.largest * motion.amplitude;
  const [unit, size] = [["m", 1], ["mm", 1e-3], ["µm", 1e-6]].find(([, s]) => shown >= s) || ["µm", 1e-6];
  return [
    `largest displacement in the picture: ${written(shown / size, 3)} ${unit}`,
    `mode ${motion.mode + 1}: ${about(mode)}`,
  ];
}

function fillModes() {
  $("modes").hidden = false;
  const body = $("modes").querySelector("tbody");
  motion.modes.forEach((mode, k) => {
    const row = body.insertRow();
    const label = added(row.insertCell(), "label");
    const input = added(label, "input", { type: "radio", name: "mode", checked: k === motion.mode });
    input.setAttribute("aria-label", `mode ${k + 1}: ${about(mode)}`);
    label.append(` ${k + 1}`);
    const frequency = mode.f === 0 ? "0 (free)" : hertz(mode.f);
    const damping = `${written(mode.damping, 3)}${mode.unstable ? " unstable" : ""}`;
    for (const text of [frequency, damping, mode.moves]) row.insertCell().textContent = text;
    row.addEventListener("click", () => chooseMode(k));
    input.addEventListener("change", () => chooseMode(k));
  });
  $("amplitude").addEventListener("input", () => setAmplitude(10 ** Number($("amplitude").value)));
}
