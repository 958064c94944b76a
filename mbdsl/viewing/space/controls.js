// Controls of the view in space, in addition to those of the page.
const ANGLE = Math.PI / 36;

["front", "side", "top", "iso"].forEach((name, k) => {
  $(`view-${name}`).addEventListener("click", () => setView(name));
  KEYS[k + 1] = () => setView(name);
});
for (const [id, key] of [["bodies", "s"], ["joints", "j"], ["ground", "g"], ["axes", "x"]]) {
  $(id).addEventListener("change", () => option(id, $(id).checked));
  KEYS[key] = () => option(id, !show[id]);
}
$("parallel").addEventListener("change", () => switchCamera($("parallel").checked));
if (!data.floor) $("ground").parentElement.hidden = true;
Object.assign(KEYS, {
  p: () => switchCamera(!view.parallel),
  ",": () => turn(-ANGLE, 0),
  ".": () => turn(ANGLE, 0),
  "<": () => move(40, 0),
  ">": () => move(-40, 0),
  ArrowUp: (event) => (event.shiftKey ? move(0, 40) : turn(0, ANGLE)),
  ArrowDown: (event) => (event.shiftKey ? move(0, -40) : turn(0, -ANGLE)),
});
canvas.addEventListener("contextmenu", (event) => event.preventDefault());
