// Controls of the view in space: buttons of standard views, options, keys; they are added to those of the page.
const VIEWS = [["front", "1"], ["side", "2"], ["top", "3"], ["iso", "4"]];
const OPTIONS = [["bodies", "S"], ["joints", "J"], ["ground", "G"], ["axes", "X"]];

function addKey(keys, words) {
  const row = document.createElement("tr");
  Object.assign(row.appendChild(document.createElement("th")), { textContent: keys });
  row.insertCell().textContent = words;
  $("keys").querySelector("tbody").insertBefore(row, $("keys").querySelector(".of-modes"));
}

function addOption(id, words, on, change) {
  const label = $("options").appendChild(document.createElement("label"));
  label.className = "check";
  const box = label.appendChild(document.createElement("input"));
  Object.assign(box, { type: "checkbox", id, checked: on });
  label.append(` ${words}`);
  box.addEventListener("change", () => change(box.checked));
}

const bar = $("stage").insertBefore(document.createElement("div"), $("view"));
Object.assign(bar, { id: "views", className: "tools" });
bar.setAttribute("role", "toolbar");
bar.setAttribute("aria-label", "Standard views");
for (const [name, key] of VIEWS) {
  const button = bar.appendChild(document.createElement("button"));
  const words = name[0].toUpperCase() + name.slice(1);
  Object.assign(button, { type: "button", id: `view-${name}`, textContent: words, title: `view from the ${name} (${key})` });
  if (name === "iso") button.title = `isometric view (${key})`;
  button.addEventListener("click", () => setView(name));
  KEYS[key] = () => setView(name);
}
for (const [id, key] of OPTIONS) {
  addOption(id, id, true, (on) => option(id, on));
  KEYS[key.toLowerCase()] = () => option(id, !show[id]);
}
addOption("parallel", "parallel projection", false, switchCamera);
if (!data.floor) $("ground").parentElement.hidden = true;

const ANGLE = Math.PI / 36;
Object.assign(KEYS, {
  p: () => switchCamera(!view.parallel),
  ",": () => turn(-ANGLE, 0),
  ".": () => turn(ANGLE, 0),
  "<": () => move(40, 0),
  ">": () => move(-40, 0),
  ArrowUp: (event) => (event.shiftKey ? move(0, 40) : turn(0, ANGLE)),
  ArrowDown: (event) => (event.shiftKey ? move(0, -40) : turn(0, -ANGLE)),
});
for (const row of $("keys").querySelectorAll("tr"))
  if (row.cells[0].textContent === "drag; ↑ ↓") {
    row.cells[0].textContent = "drag; ↑ ↓ , .";
    row.cells[1].textContent = "turn the view; the arrows on the picture";
  }
addKey("shift and drag; shift and ↑ ↓; < >", "move the view");
addKey("1, 2, 3, 4", "front, side, top, isometric view");
addKey("P", "perspective, parallel projection");
addKey("S, J, G, X", "bodies, joints, ground, axes");
canvas.addEventListener("contextmenu", (event) => event.preventDefault());
