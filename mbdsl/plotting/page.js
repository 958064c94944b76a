"use strict";
// Hovering and the legend. Without this script the page shows the same pictures. Texts are only ever set as text.
const REACH = 36; // distance within which a point shows its text [px of the picture]

for (const figure of document.querySelectorAll("figure")) {
  const source = figure.querySelector("script[type='application/json']");
  if (!source) continue;
  const data = JSON.parse(source.textContent);
  const off = new Set();
  figure.querySelectorAll(".scroll > svg").forEach((svg, k) => liven(figure, svg, k && data.narrow ? { ...data, ...data.narrow } : data, off));
  legend(figure, off);
}
share([...document.querySelectorAll("figure[data-shared] .scroll > svg")]);
addEventListener("beforeprint", () => document.querySelectorAll("details").forEach((d) => (d.open = true)));

// A line at the same place of the shared axis in all panels, which follows the pointer.
function share(panels) {
  const lines = panels.map((svg) => {
    const line = svg.querySelector(".axis").cloneNode();
    line.setAttribute("class", "cursor");
    line.setAttribute("d", "");
    svg.append(line);
    return line;
  });
  const draw = (x) =>
    panels.forEach((svg, k) => {
      const frame = svg.querySelector("clipPath rect");
      const [left, top, width, height] = ["x", "y", "width", "height"].map((name) => Number(frame.getAttribute(name)));
      const inside = x >= left && x <= left + width;
      lines[k].setAttribute("d", inside ? `M${x} ${top}v${height}` : "");
    });
  for (const svg of panels) {
    svg.addEventListener("pointermove", (event) => {
      const scale = svg.getBoundingClientRect();
      draw(((event.clientX - scale.left) / scale.width) * svg.viewBox.baseVal.width);
    });
    svg.addEventListener("pointerleave", () => draw(-1));
  }
}

// A figure has one picture for wide windows, and may have one for narrow ones.
function liven(figure, svg, data, off) {
  const ring = svg.querySelector(".ring");
  const tip = figure.appendChild(document.createElement("div"));
  tip.className = "tip";
  tip.hidden = true;
  tip.setAttribute("role", "status");
  const points = data.points.flatMap((list, k) => list.map((p) => ({ k, name: data.names[k], p })));
  for (const p of data.failed) points.push({ k: data.names.indexOf(p[6]), name: p[6], p });

  function show(found) {
    tip.hidden = !found;
    ring.setAttribute("visibility", found ? "visible" : "hidden");
    if (!found) return;
    const [px, py, x, y, spread, text] = found.p;
    ring.setAttribute("cx", px);
    ring.setAttribute("cy", py);
    const lines = [];
    if (x) lines.push(`${data.x}: ${x}`);
    if (y) lines.push(`${data.y}: ${y}`);
    if (spread) lines.push(`spread: ${spread}`);
    if (text) lines.push(text);
    const head = document.createElement("b");
    head.textContent = found.name;
    tip.replaceChildren(head, lines.join("\n"));
    const scale = svg.getBoundingClientRect();
    const frame = figure.getBoundingClientRect();
    const size = svg.viewBox.baseVal;
    const left = scale.left - frame.left + (px / size.width) * scale.width;
    const top = scale.top - frame.top + (py / size.height) * scale.height;
    const right = left + 16 + tip.offsetWidth <= frame.width;
    tip.style.left = `${Math.max(0, right ? left + 16 : left - 16 - tip.offsetWidth)}px`;
    tip.style.top = `${Math.max(0, top - tip.offsetHeight / 2)}px`;
  }

  function nearest(event) {
    const scale = svg.getBoundingClientRect();
    const size = svg.viewBox.baseVal;
    const x = ((event.clientX - scale.left) / scale.width) * size.width;
    const y = ((event.clientY - scale.top) / scale.height) * size.height;
    let best = null;
    let least = REACH;
    for (const point of points) {
      if (off.has(point.k)) continue;
      const distance = Math.hypot(point.p[0] - x, point.p[1] - y);
      if (distance < least) [best, least] = [point, distance];
    }
    return best;
  }

  svg.addEventListener("pointermove", (event) => show(nearest(event)));
  svg.addEventListener("pointerdown", (event) => show(nearest(event)));
  svg.addEventListener("pointerleave", () => show(null));

  // From point to point by the arrow keys.
  let at = -1;
  svg.setAttribute("tabindex", "0");
  svg.addEventListener("blur", () => show(null));
  svg.addEventListener("keydown", (event) => {
    const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (event.key === "Escape") show(null);
    if (!step || !points.length) return;
    event.preventDefault();
    for (let tries = 0; tries < points.length; tries += 1) {
      at = (at + step + points.length) % points.length;
      if (!off.has(points[at].k)) return show(points[at]);
    }
  });

  figure.addEventListener("hidden", () => show(null));
}

function legend(figure, off) {
  const parts = (k) => figure.querySelectorAll(`svg [data-series="${k}"]`);
  figure.querySelectorAll(".legend [data-entry]").forEach((entry) => {
    const k = Number(entry.dataset.entry);
    const button = document.createElement("button");
    button.type = "button";
    button.className = entry.className;
    button.append(...entry.childNodes);
    button.setAttribute("aria-pressed", "true");
    button.title = "show or hide";
    entry.replaceWith(button);
    button.addEventListener("click", () => {
      const hide = !off.has(k);
      hide ? off.add(k) : off.delete(k);
      button.setAttribute("aria-pressed", String(!hide));
      parts(k).forEach((part) => part.classList.toggle("off", hide));
      figure.dispatchEvent(new Event("hidden"));
    });
    const fade = (on) => () =>
      figure.querySelectorAll("svg [data-series]").forEach((part) =>
        part.classList.toggle("behind", on && !off.has(k) && part.dataset.series !== String(k)));
    button.addEventListener("pointerenter", fade(true));
    button.addEventListener("pointerleave", fade(false));
  });
}
