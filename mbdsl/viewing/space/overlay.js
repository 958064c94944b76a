// Marks over the scene: names, centres of mass, ends of paths, the scale, the directions of the axes.
function paintOverlay(g, ratio) {
  g.setTransform(ratio, 0, 0, ratio, 0, 0);
  g.clearRect(0, 0, canvas.clientWidth, canvas.clientHeight);
  g.lineCap = g.lineJoin = "round";
  letters(g);
  [...traces.keys()].forEach((name, k) => {
    const [x, y] = painter.place(data.points[name]);
    g.fillStyle = theme.bodies[k % theme.bodies.length];
    g.beginPath();
    g.arc(x, y, 3, 0, 2 * Math.PI);
    g.fill();
  });
  const bodies = Object.entries(data.bodies);
  if (show.masses) for (const [, at] of bodies) quartered(g, [...painter.place(at).slice(0, 2), 0], 5);
  if (show.labels)
    for (const [name, at] of bodies) {
      const [x, y] = painter.place(at);
      text(g, name, x + 9, y - 10);
    }
  scaleBar(g, view.scale);
  writeNotes(g, notesInSpace());
  if (show.axes) paintAxes(g);
}

function notesInSpace() {
  const notes = [];
  const units = { force: "N", torque: "N m" };
  for (const group of ["forces", "reactions"])
    for (const [kind, unit] of Object.entries(units)) {
      const most = data.largest[`${group} ${kind}`];
      const word = group === "forces" ? kind : { force: "reaction", torque: "reaction (torque)" }[kind];
      const colour = group === "forces" ? theme.load : theme.reaction;
      if (show[group] && most) notes.push([`longest arrow of a ${word}: ${written(most, 3)} ${unit}`, colour]);
    }
  if (painter.step && show.ground) notes.push(`grid ${inUnits(painter.step)}`);
  if (data.pale) notes.push(`pale: ${data.pale}`);
  return notes;
}

// The axes of the world in the lower right corner.
function paintAxes(g) {
  const [x, y] = [canvas.clientWidth - 44, canvas.clientHeight - 44];
  const ends = [[1, 0, 0], [0, 1, 0], [0, 0, 1]].map((axis, k) => [view.axes.map((a) => dot(a, axis)), k]);
  for (const [[right, up], k] of ends.sort((a, b) => a[0][2] - b[0][2])) {
    const colour = theme.bodies[[1, 2, 0][k]];
    polyline(g, [[x, y], [x + 26 * right, y - 26 * up]], 2, colour);
    g.textAlign = "center";
    text(g, "xyz"[k], x + 35 * right, y - 35 * up, colour);
  }
  letters(g);
}
