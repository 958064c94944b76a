// The scene of three.js: solids, floor, lights, arrows and paths, seen by a camera.
const FIELD = Math.PI / 6; // angle of view of the perspective camera
const SHADOWS = 1024; // pixels of the map of shadows

class Stage {
  constructor(canvas, data, motion, ghost) {
    Object.assign(this, { canvas, data, motion, ghost, theme: null, lines: new Map() });
    // with the buffer preserved, the picture is in prints, too
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, preserveDrawingBuffer: true });
    canvas.removeAttribute("data-engine"); // its attributes are the state of the view
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = THREE.PCFShadowMap;
    this.scene = new THREE.Scene();
    this.eye = new THREE.PerspectiveCamera((180 / Math.PI) * FIELD);
    this.flat = new THREE.OrthographicCamera();
    this.solids = new Solids(data, motion);
    this.scene.add(this.solids.group);
    this.behind = ghost && new Solids(data.ghost, ghost, true);
    if (this.behind) this.scene.add(this.behind.group);
    const [low, high] = data.bounds;
    this.reach = 2 * data.size + Math.hypot(...high.map((x, k) => x - low[k]));
    this.addFloor();
    this.addLights();
    this.addArrows();
  }

  addFloor() {
    this.floor = new THREE.Group();
    if (!this.data.floor) return;
    const { bounds, size, floor } = this.data;
    const matrix = matrixOf(floor.slice(1));
    const middle = new THREE.Vector3(...bounds[0].map((x, k) => (x + bounds[1][k]) / 2));
    middle.applyMatrix4(matrix.clone().invert());
    const half = 0.5 * this.reach;
    const power = 10 ** Math.floor(Math.log10(size / 5));
    this.step = [1, 2, 5, 10].map((k) => k * power).find((s) => s >= size / 8);
    while (half / this.step > 60) this.step *= 10;
    const count = Math.ceil(half / this.step);
    const [x, y] = [middle.x, middle.y].map((c) => this.step * Math.round(c / this.step));
    const end = count * this.step;
    const points = [];
    for (let k = -count; k <= count; k += 1) {
      const d = k * this.step;
      points.push(x + d, y - end, 0, x + d, y + end, 0, x - end, y + d, 0, x + end, y + d, 0);
    }
    const lines = new THREE.BufferGeometry();
    lines.setAttribute("position", new THREE.Float32BufferAttribute(points, 3));
    this.grid = new THREE.LineSegments(lines, new THREE.LineBasicMaterial());
    const plane = new THREE.PlaneGeometry(2 * end, 2 * end).translate(x, y, 0);
    this.shade = new THREE.Mesh(plane, new THREE.ShadowMaterial({ polygonOffset: true, polygonOffsetFactor: 2 }));
    this.shade.receiveShadow = true;
    this.floor.add(this.grid, this.shade);
    Object.assign(this.floor, { matrixAutoUpdate: false, matrix });
    this.scene.add(this.floor);
  }

  addLights() {
    const up = new THREE.Vector3(...this.data.axes[2]);
    const sky = new THREE.HemisphereLight(0xffffff, 0xb8b4ae, 1.9);
    sky.position.copy(up);
    this.sun = new THREE.DirectionalLight(0xffffff, 2.1);
    this.sun.castShadow = true;
    this.sun.shadow.mapSize.set(SHADOWS, SHADOWS);
    this.scene.add(sky, this.sun, this.sun.target);
  }

  // Shadows are computed in a box around the point that the camera looks at.
  shine(target, radius) {
    const { sun } = this;
    const [x, y, up] = this.data.axes;
    const from = [0, 1, 2].map((k) => 0.35 * x[k] - 0.3 * y[k] + up[k]);
    sun.target.position.set(...target);
    sun.position.set(...target.map((p, k) => p + 2 * radius * from[k]));
    const box = sun.shadow.camera;
    Object.assign(box, { left: -radius, right: radius, bottom: -radius, top: radius, near: 0.01 * radius });
    box.far = 5 * radius;
    box.updateProjectionMatrix();
    sun.shadow.normalBias = (3 * radius) / SHADOWS;
  }

  // Parts of arrows behind solids are pale.
  addArrows() {
    const part = (geometry, count) => {
      const mesh = new THREE.InstancedMesh(geometry, new THREE.MeshLambertMaterial(), Math.max(1, count));
      const look = { transparent: true, opacity: 0.3, depthFunc: THREE.GreaterDepth, depthWrite: false };
      const hidden = new THREE.InstancedMesh(geometry, new THREE.MeshLambertMaterial(look), Math.max(1, count));
      for (let k = 0; k < mesh.count; k += 1) mesh.setColorAt(k, new THREE.Color());
      Object.assign(hidden, { instanceMatrix: mesh.instanceMatrix, instanceColor: mesh.instanceColor });
      mesh.frustumCulled = hidden.frustumCulled = false;
      if (count) this.scene.add(mesh, hidden);
      return mesh;
    };
    this.shafts = part(GEOMETRIES.bar({}), vectors.length);
    this.heads = part(upright(new THREE.ConeGeometry(1, 1, 20)), 2 * vectors.length);
  }

  setTheme(theme) {
    this.theme = theme;
    this.renderer.setClearColor(theme.paper);
    this.solids.paint(theme);
    if (this.behind) this.behind.paint(theme);
    if (this.grid) {
      this.grid.material.color.set(theme.grid);
      this.shade.material.opacity = theme.paper === "#ffffff" ? 0.2 : 0.45;
    }
    vectors.forEach((v, k) => {
      const colour = new THREE.Color(colourOf(v));
      this.shafts.setColorAt(k, colour);
      this.heads.setColorAt(2 * k, colour);
      this.heads.setColorAt(2 * k + 1, colour);
    });
    for (const mesh of [this.shafts, this.heads]) mesh.instanceColor.needsUpdate = true;
  }

  paint(view, theme, show) {
    if (theme !== this.theme) this.setTheme(theme);
    if (this.ghost) this.ghost.seek(this.motion.time);
    this.solids.update(show);
    if (this.behind) this.behind.update(show);
    this.floor.visible = show.ground;
    this.updateArrows(show);
    this.updateTraces();
    this.shine(view.target, Math.min(this.reach, 1.2 * view.height));
    this.renderer.render(this.scene, this.look(view));
  }

  // The camera of a view: its axes are those of the picture.
  look({ target, height, parallel, axes }) {
    const [right, up, towards] = axes;
    const aspect = this.canvas.clientWidth / this.canvas.clientHeight;
    const camera = parallel ? this.flat : this.eye;
    const away = parallel ? 2 * this.reach + height : distance(height);
    if (parallel) {
      Object.assign(camera, { left: (-aspect * height) / 2, right: (aspect * height) / 2, top: height / 2 });
      Object.assign(camera, { bottom: -height / 2, near: 0, far: 2 * away });
    } else Object.assign(camera, { aspect, near: 0.02 * away, far: away + 2 * this.reach });
    camera.position.set(...target.map((p, k) => p + away * towards[k]));
    const [x, y, z] = [right, up, towards].map((axis) => new THREE.Vector3(...axis));
    camera.quaternion.setFromRotationMatrix(new THREE.Matrix4().makeBasis(x, y, z));
    camera.updateProjectionMatrix();
    return camera;
  }

  updateArrows(show) {
    const longest = (0.22 * Math.min(1, this.canvas.clientWidth / this.canvas.clientHeight) * view.height) * show.size;
    const none = new THREE.Matrix4().makeScale(0, 0, 0);
    vectors.forEach((v, k) => {
      const along = new THREE.Vector3(...valuesOf(v)).multiplyScalar(longest / (data.largest[v.key] || 1));
      const length = along.length();
      const shown = show[v.group] && length > 0.01 * longest;
      const head = Math.min(0.15 * longest, 0.6 * length);
      const [thin, wide] = [0.018 * longest, 0.3 * head];
      const from = new THREE.Vector3(...this.motion.point(v.at));
      const at = (part) => from.clone().addScaledVector(along, part / (length || 1));
      const put = (mesh, index, p, q, r) =>
        mesh.setMatrixAt(index, shown ? spanning(p, q, [r, r], new THREE.Matrix4()) : none);
      put(this.shafts, k, at(0), at(length - head), thin);
      put(this.heads, 2 * k, at(length - head), at(length), wide);
      // a torque has two heads
      if (v.kind === "torque") put(this.heads, 2 * k + 1, at(length - 1.8 * head), at(length - 0.8 * head), wide);
      else this.heads.setMatrixAt(2 * k + 1, none);
    });
    this.shafts.instanceMatrix.needsUpdate = this.heads.instanceMatrix.needsUpdate = true;
  }

  // Paths of points: pale as a whole, strong up to the present.
  updateTraces() {
    for (const [name, pair] of this.lines)
      if (traces.get(name) !== pair.path) {
        for (const line of [pair.whole, pair.part]) {
          this.scene.remove(line);
          line.geometry.dispose();
        }
        this.lines.delete(name);
      }
    [...traces].forEach(([name, path], k) => {
      if (!this.lines.has(name)) this.lines.set(name, { path, whole: this.line(path, 0.3), part: this.line(path, 1) });
      const { whole, part } = this.lines.get(name);
      for (const line of [whole, part]) line.material.color.set(this.theme.bodies[k % this.theme.bodies.length]);
      part.geometry.instanceCount = this.motion.row;
    });
  }

  line(path, opacity) {
    const geometry = new THREE.LineGeometry().setPositions(path.flat());
    const look = { linewidth: 2, transparent: opacity < 1, opacity };
    const found = new THREE.Line2(geometry, new THREE.LineMaterial(look));
    found.frustumCulled = false;
    this.scene.add(found);
    return found;
  }

  resize(width, height, ratio) {
    this.renderer.setPixelRatio(Math.min(2, ratio));
    this.renderer.setSize(width, height, false);
  }
}

// The distance of the camera at which a height fills the picture.
function distance(height) {
  return height / 2 / Math.tan(FIELD / 2);
}

// In place of the stage where WebGL is not available: a picture of the start.
class Still {
  constructor(picture) {
    const box = added($("stage"), "div", { id: "still" });
    const svg = new DOMParser().parseFromString(picture, "text/html").querySelector("svg");
    box.appendChild(document.importNode(svg, true));
    const why = "This browser does not offer WebGL, which the animation needs: the picture shows the start.";
    added(box, "p", { textContent: why });
  }

  reach = 1;

  paint() {}

  resize() {}
}
