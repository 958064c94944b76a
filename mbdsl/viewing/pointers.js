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
  const pose = motion.pose(found[3]);
  const words = data.origin.map((from, k) => `${"xyz"[k]} = ${written(pose[k] + from)} m`);
  $("tip").textContent = `${found[0]}  ${words.join(", ")}`;
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
    drag(to[0] - from[0], to[1] - from[1], event);
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
