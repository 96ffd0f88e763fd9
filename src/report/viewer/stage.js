// The three.js side: what is drawn, and drawing it when something has changed.
import {
  BufferAttribute, BufferGeometry, ColorManagement, DoubleSide, Group,
  LineBasicMaterial, LineLoop, Line, LineSegments, LinearSRGBColorSpace, Mesh,
  MeshBasicMaterial, PerspectiveCamera, Plane, Points, PointsMaterial, Scene, SphereGeometry,
  Vector3, WebGLRenderer,
} from 'three';

// Colours go to the screen as they are.
ColorManagement.enabled = false;

const ROBOT_COLOURS = [0x0b6bcb, 0xd06a00, 0x8a3ffc, 0x00857a, 0xc2255c, 0x6b7280];

export function makeRenderer(canvas) {
  // The buffer is kept for printing.
  const renderer = new WebGLRenderer({canvas, antialias: true, preserveDrawingBuffer: true});
  renderer.outputColorSpace = LinearSRGBColorSpace;
  renderer.localClippingEnabled = true;
  return renderer;
}

function geometryOf(positions) {
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(positions, 3));
  return geometry;
}

function makePoints(points, colours, clip) {
  const geometry = geometryOf(points.positions);
  geometry.setAttribute('color', new BufferAttribute(colours, 3, true));
  const material = new PointsMaterial({
    vertexColors: true, sizeAttenuation: false, size: 2, clippingPlanes: [clip],
  });
  const object = new Points(geometry, material);
  object.frustumCulled = false;
  return object;
}

// The chosen points once more, over everything else: what is inside a hall shows through its roof.
function makeChosen(points) {
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', points.geometry.attributes.position);
  geometry.setAttribute('color', points.geometry.attributes.color);
  const object = new Points(geometry, points.material);
  object.frustumCulled = false;
  object.visible = false;
  object.renderOrder = 1;
  object.onBeforeRender = (renderer) => renderer.clearDepth();
  return object;
}

// A convex polygon as a fan of triangles.
function outlineMesh(corners, material) {
  const indices = [];
  for (let i = 2; i < corners.length / 3; i++) indices.push(0, i - 1, i);
  const geometry = geometryOf(corners);
  geometry.setIndex(indices);
  return new Mesh(geometry, material);
}

function cornersOf(plane, scene) {
  return Float32Array.from(plane[4], (value, i) => value / 100 - scene.extent[i % 3] / 2);
}

// All planes of a scan in one object; `planes` of the scene are [scan, number, area, rms, corners].
function makePlanes(scene, clip) {
  const group = new Group();
  const fill = new MeshBasicMaterial({
    color: 0x3d7ab8, opacity: 0.1, transparent: true, side: DoubleSide, depthWrite: false,
    clippingPlanes: [clip],
  });
  const line = new LineBasicMaterial({
    color: 0x3d7ab8, opacity: 0.6, transparent: true, clippingPlanes: [clip],
  });
  for (const plane of scene.planes) {
    const corners = cornersOf(plane, scene);
    const outline = new Group();
    outline.userData = {scan: plane[0], number: plane[1], area: plane[2], rms: plane[3]};
    outline.add(outlineMesh(corners, fill), new LineLoop(geometryOf(corners), line));
    group.add(outline);
  }
  return group;
}

function makeWays(scene, frame) {
  const group = new Group();
  const ball = new SphereGeometry(1, 16, 12);
  // A way ends where the component changes: between components no step is known.
  const ways = [];
  const last = scene.robots.map(() => null);
  scene.scans.forEach((scan, index) => {
    if (scan.at === null) return;
    const at = frame.toView(scan.at);
    if (last[scan.robot]?.component !== scan.component) {
      last[scan.robot] = {robot: scan.robot, component: scan.component, places: []};
      ways.push(last[scan.robot]);
    }
    last[scan.robot].places.push(...at);
    const colour = ROBOT_COLOURS[scan.robot % ROBOT_COLOURS.length];
    const marker = new Mesh(ball, new MeshBasicMaterial({color: colour}));
    marker.position.set(...at);
    marker.userData = {scan: index};
    group.add(marker);
  });
  ways.forEach(({robot, places}) => {
    const colour = ROBOT_COLOURS[robot % ROBOT_COLOURS.length];
    group.add(new Line(geometryOf(Float32Array.from(places)), new LineBasicMaterial({color: colour})));
  });
  return group;
}

// Small crosses where the drone's pictures were taken.
function makeCameras(scene, frame) {
  const ends = [];
  const reach = 0.004 * Math.hypot(scene.extent[0], scene.extent[1]);
  for (const camera of scene.cameras) {
    const [x, y, z] = frame.toView(camera);
    ends.push(x - reach, y, z, x + reach, y, z, x, y - reach, z, x, y + reach, z);
  }
  return new LineSegments(
    geometryOf(Float32Array.from(ends)), new LineBasicMaterial({color: 0xb08a3c}));
}

function makePickMark() {
  const mark = new Mesh(
    new SphereGeometry(1, 16, 12),
    new MeshBasicMaterial({color: 0xe0218a, opacity: 0.9, transparent: true, depthTest: false}));
  mark.visible = false;
  return mark;
}

/// Everything that is drawn. draw() may be called any number of times; a frame is drawn once.
export class Stage {
  constructor(canvas, scene, frame, points) {
    this.renderer = makeRenderer(canvas);
    this.scene = new Scene();
    this.camera = new PerspectiveCamera(50, 1, 0.05, 5000);
    this.camera.up.set(0, 0, 1);
    this.clip = new Plane(new Vector3(0, 0, -1), scene.extent[2]);
    this.colours = new Uint8Array(3 * points.count);
    this.points = makePoints(points, this.colours, this.clip);
    this.chosen = makeChosen(this.points);
    this.planes = makePlanes(scene, this.clip);
    this.ways = makeWays(scene, frame);
    this.ways.renderOrder = 2;
    this.cameras = makeCameras(scene, frame);
    this.mark = makePickMark();
    this.scene.add(this.points, this.chosen, this.planes, this.ways, this.cameras, this.mark);
    this.pointSize = 1.5;  // CSS pixels
    this.pending = false;
  }

  coloursChanged() {
    this.points.geometry.attributes.color.needsUpdate = true;
    this.draw();
  }

  /// Draws the points with these indices over all others; null: none is chosen.
  choosePoints(indices) {
    this.chosen.visible = indices !== null;
    this.chosen.geometry.setIndex(
      indices === null ? null : new BufferAttribute(Uint32Array.from(indices), 1));
    this.draw();
  }

  /// Nothing above this height (of the view's frame) is drawn.
  cutAt(height) {
    this.clip.constant = height;
    this.draw();
  }

  /// Shows the planes of the chosen scans; null: of all.
  showPlanesOf(scans) {
    for (const outline of this.planes.children) {
      outline.visible = scans === null || scans.includes(outline.userData.scan);
    }
    this.draw();
  }

  resize(width, height) {
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / Math.max(height, 1);
    this.camera.updateProjectionMatrix();
    this.setPointSize(this.pointSize);
  }

  setPointSize(pixels) {
    this.pointSize = pixels;
    this.points.material.size = pixels * this.renderer.getPixelRatio();
    this.draw();
  }

  draw() {
    if (this.pending) return;
    this.pending = true;
    requestAnimationFrame(() => {
      this.pending = false;
      this.drawNow();
    });
  }

  drawNow() {
    // Markers keep about their size on the screen.
    for (const object of [...this.ways.children, this.mark]) {
      if (object.isMesh) {
        object.scale.setScalar(0.008 * object.position.distanceTo(this.camera.position));
      }
    }
    this.renderer.render(this.scene, this.camera);
  }
}
