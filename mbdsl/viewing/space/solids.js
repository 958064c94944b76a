// The solids of a mechanism: one instanced mesh for each geometry, whose matrices follow the motion.
const MOST_EDGES = 300; // number of solids up to which edges are drawn
const MANY = 300; // number of solids of a kind from which they are coarse
const UNIT = new THREE.Vector3(1, 1, 1);
const ALONG = new THREE.Vector3(0, 0, 1);

function matrixOf([x, y, z, w = 1, a = 0, b = 0, c = 0], size = UNIT) {
  return new THREE.Matrix4().compose(new THREE.Vector3(x, y, z), new THREE.Quaternion(a, b, c, w), size);
}

// The matrix of a solid that extends from p to q along its z axis.
function spanning(p, q, [x, y], matrix) {
  const way = q.clone().sub(p);
  const length = Math.max(way.length(), 1e-9);
  const turn = new THREE.Quaternion().setFromUnitVectors(ALONG, way.divideScalar(length));
  return matrix.compose(p.clone().lerp(q, 0.5), turn, new THREE.Vector3(x, y, length));
}

class Solids {
  constructor(data, motion, pale = false) {
    Object.assign(this, { data, motion, pale, group: new THREE.Group(), meshes: [], edges: [] });
    this.order = new Map(Object.keys(data.bodies).map((name, k) => [name, k]));
    this.tracks = data.tracks.map(() => new THREE.Matrix4());
    const kinds = new Map();
    for (const solid of data.solids) {
      const key = [solid.draw, solid.bore, solid.turns, solid.points && solid.name, solid.role === "body"].join();
      if (!kinds.has(key)) kinds.set(key, []);
      kinds.get(key).push({ ...solid, matrix: new THREE.Matrix4(), local: this.local(solid) });
    }
    const edged = !pale && data.solids.length <= MOST_EDGES;
    for (const solids of kinds.values()) this.add(solids, edged);
  }

  // A solid on one track is placed by a constant matrix.
  local({ at, size }) {
    return at.length === 1 ? matrixOf(at[0].slice(1), new THREE.Vector3(...size)) : null;
  }

  add(solids, edged) {
    const { draw, role } = solids[0];
    const paint = { polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1, side: THREE.DoubleSide };
    if (this.pale) Object.assign(paint, { transparent: true, opacity: 0.28, depthWrite: false });
    const material = new THREE.MeshLambertMaterial(paint);
    const geometry = GEOMETRIES[draw]({ ...solids[0], coarse: solids.length > MANY });
    const mesh = new THREE.InstancedMesh(geometry, material, solids.length);
    mesh.frustumCulled = false;
    mesh.castShadow = mesh.receiveShadow = !this.pale;
    mesh.userData = { solids, body: role === "body" };
    this.meshes.push(mesh);
    this.group.add(mesh);
    const edges = edged && edgesOf(draw);
    if (!edges) return;
    const pen = new THREE.LineBasicMaterial();
    for (const solid of solids) {
      const line = new THREE.LineSegments(edges, pen);
      Object.assign(line, { matrixAutoUpdate: false, frustumCulled: false, userData: mesh.userData });
      line.matrix = solid.matrix;
      this.edges.push(line);
      this.group.add(line);
    }
  }

  paint(theme) {
    const roles = { joint: theme.pale, force: theme.force, drive: theme.drive, support: mixed(theme.pale, theme.paper, 0.5) };
    for (const mesh of this.meshes) {
      mesh.userData.solids.forEach(({ role, name }, k) => {
        const body = this.order.get(name);
        const own = body === undefined ? theme.rod : theme.bodies[body % theme.bodies.length];
        mesh.setColorAt(k, new THREE.Color(role === "body" ? mixed(own, theme.paper, 0.12) : roles[role]));
      });
      mesh.instanceColor.needsUpdate = true;
    }
    for (const line of this.edges) line.material.color.set(mixed(theme.ink, theme.paper, 0.15));
  }

  update(show) {
    const { now } = this.motion;
    this.tracks.forEach((matrix, k) => matrix.copy(matrixOf(now.subarray(7 * k, 7 * k + 7))));
    for (const mesh of this.meshes) {
      mesh.visible = mesh.userData.body ? show.bodies : show.joints;
      if (!mesh.visible) continue;
      mesh.userData.solids.forEach((solid, k) => {
        const { at, local, matrix, size } = solid;
        if (!local) {
          const [p, q] = at.map((place) => new THREE.Vector3(...this.motion.point(place)));
          spanning(p, q, size, matrix);
        } else if (at[0][0] < 0) matrix.copy(local);
        else matrix.multiplyMatrices(this.tracks[at[0][0]], local);
        mesh.setMatrixAt(k, matrix);
      });
      mesh.instanceMatrix.needsUpdate = true;
    }
    for (const line of this.edges) line.visible = line.userData.body ? show.bodies : show.joints;
  }
}
