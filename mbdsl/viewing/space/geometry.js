// Geometries of unit size, by the names of solids: centred, round ones about the z axis, from z = -0.5 to 0.5.
const SIDES = 48;
const PITCH = 1.6; // of coils, relative to their radius; as in symbols.py

function upright(geometry) {
  return geometry.rotateX(Math.PI / 2);
}

function round(radius, from, to, sides = SIDES) {
  return upright(new THREE.CylinderGeometry(radius, radius, to - from, sides)).translate(0, 0, (from + to) / 2);
}

// A tube of a radius along points (part of the way from 0 to 1) -> [x, y, z].
function wire(points, count, radius) {
  const path = Array.from({ length: count + 1 }, (_, k) => new THREE.Vector3(...points(k / count)));
  return new THREE.TubeGeometry(new THREE.CatmullRomCurve3(path), 2 * count, radius, 8);
}

function helix(turns, length) {
  return (part) => {
    const angle = 2 * Math.PI * turns * part;
    return [Math.cos(angle), Math.sin(angle), length * (part - 0.5)];
  };
}

function wheel() {
  const spokes = Array.from({ length: 4 }, (_, k) =>
    round(0.016, -0.94, 0.94, 8).rotateX(Math.PI / 2).rotateZ((k * Math.PI) / 4),
  );
  return THREE.mergeGeometries([new THREE.TorusGeometry(0.955, 0.045, 12, SIDES), round(0.09, -0.1, 0.1), ...spokes]);
}

function hollow(bore) {
  const corners = [[bore, -0.5], [1, -0.5], [1, 0.5], [bore, 0.5], [bore, -0.5]];
  const lathe = new THREE.LatheGeometry(corners.map(([x, y]) => new THREE.Vector2(x, y)), SIDES);
  const geometry = upright(lathe).toNonIndexed();
  geometry.computeVertexNormals();
  return geometry;
}

const GEOMETRIES = {
  bar: ({ coarse }) => round(1, -0.5, 0.5, coarse ? 7 : 16),
  cylinder: ({ coarse }) => round(1, -0.5, 0.5, coarse ? 12 : SIDES),
  box: () => new THREE.BoxGeometry(1, 1, 1),
  ball: ({ coarse }) => new THREE.SphereGeometry(1, coarse ? 10 : 32, coarse ? 7 : 20),
  tube: ({ bore }) => hollow(bore),
  wheel,
  ring: () => new THREE.TorusGeometry(1, 0.12, 12, SIDES),
  spiral: () => wire((part) => helix(3, 0)(part).map((x) => x * (0.2 + 0.8 * part)), 60, 0.07),
  coil: ({ turns }) => {
    const length = PITCH * turns;
    return wire(helix(turns, length), 16 * turns, 0.16).scale(1, 1, 1 / length);
  },
  wire: ({ points, radius }) => wire((part) => points[Math.round(part * (points.length - 1))], points.length - 1, radius),
  piston: () => THREE.mergeGeometries([round(1, -0.5, 0.05), round(0.45, 0, 0.5)]),
};

// Edges of solids as pairs of points. Radii on the ends of cylinders show that they turn.
function edgesOf(draw) {
  if (draw === "box") return new THREE.EdgesGeometry(new THREE.BoxGeometry(1, 1, 1));
  if (draw !== "cylinder" && draw !== "tube") return null;
  const points = [];
  for (const z of [-0.5, 0.5]) {
    const rim = (angle) => [Math.cos(angle), Math.sin(angle), z];
    for (let k = 0; k < SIDES; k += 1)
      points.push(...rim((2 * Math.PI * k) / SIDES), ...rim((2 * Math.PI * (k + 1)) / SIDES));
    if (draw === "cylinder")
      for (const k of [0, 1, 2]) points.push(0, 0, z, ...rim((2 * Math.PI * k) / 3));
  }
  const geometry = new THREE.BufferGeometry();
  return geometry.setAttribute("position", new THREE.Float32BufferAttribute(points, 3));
}
