// The view of a model in space: where the camera is, and what it does when the user turns, moves and zooms.
const drawable = Boolean(document.createElement("canvas").getContext("webgl2"));
const painter = drawable ? new Stage(canvas, data, motion, ghost) : new Still(data.picture);
const surface = $("stage").insertBefore(document.createElement("canvas"), $("tip")); // for marks over the scene
surface.id = "overlay";
document.body.classList.add("space");
// `target` is the point in the middle of the picture, `height` that of the picture at this point [m]
const view = { target: [0, 0, 0], azimuth: 0, elevation: 0, height: 1, scale: 1, parallel: false, axes: [] };
// the target relative to the followed body
Object.assign(view, { offset: [0, 0, 0], followed: null });
Object.assign(show, { bodies: true, joints: true, ground: true, axes: true });
const [AXIS_X, AXIS_Y, AXIS_UP] = data.axes;

function dot(a, b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

function sum(...terms) {
  return [0, 1, 2].map((k) => terms.reduce((found, [factor, a]) => found + factor * a[k], 0));
}

// The axes of the picture: to the right, upwards, towards the viewer.
function orient() {
  const [c, s] = [Math.cos(view.azimuth), Math.sin(view.azimuth)];
  const [level, high] = [Math.cos(view.elevation), Math.sin(view.elevation)];
  const right = sum([-s, AXIS_X], [c, AXIS_Y]);
  const up = sum([-high * c, AXIS_X], [-high * s, AXIS_Y], [level, AXIS_UP]);
  view.axes = [right, up, sum([level * c, AXIS_X], [level * s, AXIS_Y], [high, AXIS_UP])];
}

function setView(name) {
  [view.azimuth, view.elevation] = data.views[name];
  orient();
  if (fitted) fit();
  else redraw();
}

function turn(azimuth, elevation) {
  view.azimuth += azimuth;
  view.elevation = Math.min(Math.PI / 2, Math.max(-Math.PI / 2, view.elevation + elevation));
  orient();
  redraw();
}

function move(dx, dy) {
  if (follow !== null) followBody("");
  const [right, up] = view.axes;
  view.target = sum([1, view.target], [-dx / view.scale, right], [dy / view.scale, up]);
  fitted = false;
  redraw();
}

// With shift, or with another button than the left one, the view moves instead of turning.
function drag(dx, dy, event) {
  if (event.shiftKey || event.buttons & 6) move(dx, dy);
  else turn(-0.008 * dx, 0.008 * dy);
}

function zoom(factor, x = canvas.clientWidth / 2, y = canvas.clientHeight / 2) {
  const before = view.scale;
  view.height = Math.min(50 * painter.reach, Math.max(1e-3 * data.unit, view.height / factor));
  measure();
  const part = 1 / before - 1 / view.scale; // the point below the pointer stays there
  const [right, up] = view.axes;
  const [dx, dy] = [x - canvas.clientWidth / 2, y - canvas.clientHeight / 2];
  if (follow === null) view.target = sum([1, view.target], [part * dx, right], [-part * dy, up]);
  fitted = false;
  redraw();
}

function measure() {
  view.scale = (canvas.clientHeight || 1) / view.height;
}

// Points of a solid, each with its distance from the edge.
function hull({ draw, at, size: [x, y, z], points, radius }) {
  if (at.length > 1) return at.map((place) => [place, x]);
  const matrix = matrixOf(at[0].slice(1));
  const placed = (p) => [at[0][0], ...new THREE.Vector3(...p).applyMatrix4(matrix)];
  if (draw === "wire") return points.map((p) => [placed(p), radius]);
  const corners = draw === "box" ? [-0.5, 0.5].flatMap((i) => [-0.5, 0.5].map((j) => [i * x, j * y])) : [[0, 0]];
  const ends = ["box", "bar", "cylinder", "tube"].includes(draw) ? [-0.5 * z, 0.5 * z] : [0];
  return ends.flatMap((c) => corners.map((corner) => [placed([...corner, c]), draw === "box" ? 0 : x]));
}

// Points of mechanisms with their distances from the edges of solids, at several times; `only`: around a body.
function cloud(only) {
  const found = [];
  for (const [shown, moving] of [[data, motion], [data.ghost, ghost]]) {
    if (!shown) continue;
    const places = shown.solids.flatMap(hull);
    const skip = Math.ceil(places.length / 400);
    const some = [...Object.values(shown.bodies).map((at) => [at, 0]), ...places.filter((_, k) => k % skip === 0)];
    const { time } = moving;
    for (let k = 0; k <= 20; k += 1) {
      moving.seek(first + (k / 20) * (last - first));
      const from = only === null ? [0, 0, 0] : moving.point([only, 0, 0, 0]);
      for (const [at, reach] of some) found.push([sum([1, moving.point(at)], [-1, from]), reach]);
    }
    moving.seek(time);
  }
  return found.filter(([point]) => point.every(Number.isFinite));
}

// All of the motion, or the mechanism around the followed body.
function fit() {
  const points = cloud(follow);
  const aspect = canvas.clientWidth / canvas.clientHeight || 1;
  const tangent = view.parallel ? 0 : Math.tan(FIELD / 2);
  const spans = view.axes.map((axis) => {
    const along = points.map(([p]) => dot(axis, p));
    const [low, high] = [Math.min(...along), Math.max(...along)];
    return points.length ? [(low + high) / 2, along] : [0, []];
  });
  const [right, up, near] = spans.map(([middle, along]) => along.map((x) => x - middle));
  view.target = view.offset = sum(...spans.map(([middle], k) => [middle, view.axes[k]]));
  view.followed = follow;
  view.height = 0;
  points.forEach(([, reach], k) => {
    const wide = Math.max(Math.abs(up[k]) + reach, (Math.abs(right[k]) + reach) / aspect);
    view.height = Math.max(view.height, 2.2 * (wide + tangent * near[k]));
  });
  view.height = view.height > 0 ? view.height : data.size;
  fitted = true;
  redraw();
}

function centre() {
  if (follow === null) return;
  if (view.followed !== follow) [view.followed, view.offset] = [follow, [0, 0, 0]];
  view.target = sum([1, motion.point([follow, 0, 0, 0])], [1, view.offset]);
}

function switchCamera(parallel) {
  view.parallel = parallel;
  $("parallel").checked = parallel;
  if (fitted) fit();
  else redraw();
}

// The place of a point of the world in the picture [px], and its nearness to the viewer [m].
function projected(point) {
  const away = sum([1, point], [-1, view.target]);
  const [x, y, z] = view.axes.map((axis) => dot(axis, away));
  const far = distance(view.height);
  const scale = view.parallel ? view.scale : z < 0.98 * far ? (view.scale * far) / (far - z) : NaN;
  return [canvas.clientWidth / 2 + scale * x, canvas.clientHeight / 2 - scale * y, z];
}

painter.place = (at) => projected(motion.point(at));
painter.axes = (at) => {
  const [origin, p] = [motion.point(at), motion.attitude(at)];
  const axes = [[1, 0, 0], [0, 1, 0], [0, 0, 1]].map((axis) => turnedBy(p, 0, axis));
  return [origin, ...axes.map((axis) => sum([1, origin], [AXIS / view.scale, axis]))].map(projected);
};

function viewState() {
  const { scale, azimuth, elevation, target, parallel } = view;
  return { scale, azimuth, elevation, x: target[0], y: target[1], z: target[2], parallel: Number(parallel) };
}

function paintPicture(g) {
  measure();
  centre();
  painter.paint(view, theme, show);
  if (!drawable) return;
  paintFrames(g);
  paintTips(g);
  paintBodies(g, 5, [9, -10]);
  scaleBar(g, view.scale);
  writeNotes(g);
  if (show.axes) paintAxes(g);
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
}

[view.azimuth, view.elevation] = data.views[data.view];
orient();
