// The view as a whole: points, controls, and what is chosen.
import {legendOf, paint, usualHeights} from './colours.js';
import {frameOf, NO_RESIDUAL} from './data.js';
import {Navigation} from './navigation.js';
import {Panel} from './panel.js';
import {onClick, pickMarker, pickPoint} from './picking.js';
import {Stage} from './stage.js';

const DIRECTION = [-0.45, -0.7, 0.62];  // from where the site is seen first

function cssColour(name) {
  const probe = document.createElement('span');
  probe.style.color = `var(${name})`;
  document.body.append(probe);
  const colour = getComputedStyle(probe).color.match(/[\d.]+/g).slice(0, 3).map(Number);
  probe.remove();
  return colour;
}

export class Viewer {
  constructor(box, scene, points) {
    this.box = box;
    this.scene = scene;
    this.points = points;
    this.frame = frameOf(scene);
    this.mode = 'rgb';
    this.choice = null;
    this.picked = null;
    this.heights = usualHeights(points);
    this.panel = new Panel(box, {
      setMode: (mode) => this.setMode(mode),
      showAll: () => { this.choose(null); this.lookAtAll(); },
      fromAbove: () => this.lookAtAll([0, -0.001, 1]),
    });
    this.canvas = this.panel.canvas;
    this.stage = new Stage(this.canvas, scene, this.frame, points);
    this.navigation = new Navigation(this.stage, this.canvas, () => {});
    this.addLayers();
    onClick(this.canvas, (event) => this.pick(event));
    new ResizeObserver(() => this.resize()).observe(this.panel.picture);
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => this.repaint());
    this.resize();
    this.repaint();
    this.lookAtAll();
    this.sayWhatIsShown();
  }

  // ---- layers ----

  addLayers() {
    const {stage, panel, scene} = this;
    const drone = this.points.scans.findIndex((scan) => scan >= 0);
    this.droneCount = drone < 0 ? this.points.count : drone;
    this.shown = {laser: true, drone: true};
    if (this.droneCount > 0) {
      panel.addLayer('laser', true, (on) => this.showSource('laser', on));
      panel.addLayer('drone', true, (on) => this.showSource('drone', on));
    }
    const layer = (text, object, shown) => {
      object.visible = shown;
      panel.addLayer(text, shown, (on) => {
        object.visible = on;
        stage.draw();
      });
    };
    layer('ways and scans', stage.ways, true);
    if (scene.planes.length > 0) layer('planes', stage.planes, false);
    if (scene.cameras.length > 0) layer('cameras', stage.cameras, false);
    panel.addRange('point size', 1, 6, 0.5, stage.pointSize, (size) => stage.setPointSize(size));
    const top = scene.extent[2] / 2;
    panel.addRange('cut off above', -top, top, scene.extent[2] / 400, top, (z) => stage.cutAt(z));
  }

  // The drone's points come first.
  showSource(source, on) {
    this.shown[source] = on;
    const first = this.shown.drone ? 0 : this.droneCount;
    const last = this.shown.laser ? this.points.count : this.droneCount;
    this.stage.points.geometry.setDrawRange(first, Math.max(0, last - first));
    this.stage.draw();
  }

  // ---- colours ----

  setMode(mode) {
    this.mode = mode;
    this.panel.select.value = mode;
    this.repaint();
  }

  repaint() {
    const background = cssColour('--view');
    this.stage.renderer.setClearColor(`rgb(${background.join(',')})`);
    paint(this.stage.colours, this.mode, this.points, this.heights, this.choice, background);
    this.stage.coloursChanged();
    this.panel.showLegend(
      legendOf(this.mode, this.scene, this.heights, (p) => this.frame.toWorld(p)));
    this.box.dataset.mode = this.mode;
  }

  // ---- where to look ----

  resize() {
    const {clientWidth, clientHeight} = this.panel.picture;
    if (clientWidth > 0) this.stage.resize(clientWidth, clientHeight);
  }

  // The middle and reach of the points with these indices, without the outermost tenth.
  surroundings(isWanted) {
    const sides = [[], [], []];
    const step = Math.max(1, Math.floor(this.points.count / 60000));
    for (let i = 0; i < this.points.count; i += step) {
      if (!isWanted(this.points.scans[i])) continue;
      for (let axis = 0; axis < 3; axis++) sides[axis].push(this.points.positions[3 * i + axis]);
    }
    if (sides[0].length < 10) return null;
    const spans = sides.map((values) => {
      values.sort((a, b) => a - b);
      const at = (share) => values[Math.round(share * (values.length - 1))];
      return [at(0.05), at(0.95)];
    });
    return {
      middle: spans.map(([low, high]) => (low + high) / 2),
      reach: Math.max(...spans.map(([low, high]) => (high - low) / 2), 2),
    };
  }

  lookAtAll(direction = DIRECTION) {
    // Narrow pictures see less to the sides.
    const room = Math.min(1, this.stage.camera.aspect);
    const all = this.surroundings(() => true) ?? {middle: [0, 0, 0], reach: 10};
    this.navigation.lookAt(all.middle, 2.3 * all.reach / room, direction);
  }

  lookAtScans(scans) {
    const around = this.surroundings((scan) => scans.includes(scan));
    const room = Math.min(1, this.stage.camera.aspect);
    if (around) this.navigation.lookAt(around.middle, 2.6 * around.reach / room, null);
  }

  // ---- choosing ----

  choose(choice) {
    this.choice = choice;
    const scans = choice === null ? null : Object.values(choice);
    this.stage.showPlanesOf(scans);
    this.stage.choosePoints(scans === null ? null : this.pointsOf(scans));
    this.repaint();
    this.box.dataset.choice = choice === null ? '' : JSON.stringify(choice);
  }

  // A drone map in a registration is the surroundings: only its scan stands out.
  pointsOf(scans) {
    const wanted = new Set(scans.filter((scan) => scan >= 0));
    const indices = [];
    for (let i = 0; i < this.points.count; i++) {
      if (wanted.has(this.points.scans[i])) indices.push(i);
    }
    return indices;
  }

  backTo(origin) {
    if (origin === null) return [];
    return [['Back to the table', () => {
      origin.scrollIntoView({block: 'center'});
      origin.focus({preventScroll: true});
    }]];
  }

  sayWhatIsShown() {
    const {count, total} = this.scene;
    const number = (n) => n.toLocaleString('en').replaceAll(',', '\u202f');
    this.panel.say(`${number(count)} of ${number(total)} points are shown.`);
  }

  end() {
    this.choose(null);
    this.sayWhatIsShown();
  }

  showScan(index, origin) {
    const scan = this.scene.scans[index];
    this.choose({scan: index});
    this.lookAtScans([index]);
    this.panel.say(`Scan ${scan.id}.`, [['Show all', () => this.end()], ...this.backTo(origin)]);
  }

  showRegistration(index, origin) {
    const [target, source] = this.scene.registrations[index];
    const name = (scan) => this.scene.scans[scan]?.id ?? 'the drone map';
    this.choose({target, source});
    this.lookAtScans([source, ...(target >= 0 ? [target] : [])]);
    this.panel.say(`Registration of ${name(source)} (orange) to ${name(target)}` +
      `${target >= 0 ? ' (blue)' : ''}.`,
      [['Show all', () => this.end()], ...this.backTo(origin)]);
  }

  show(kind, index, origin) {
    if (kind === 'scan') this.showScan(index, origin);
    else this.showRegistration(index, origin);
  }

  // ---- single points ----

  pick(event) {
    const marker = pickMarker(event, this.stage, this.canvas);
    if (marker >= 0) return this.showScan(marker, null);
    const index = pickPoint(event, this.stage, this.canvas, this.points, this.drawn());
    if (index >= 0) this.sayPoint(index);
  }

  drawn() {
    const {start, count} = this.stage.points.geometry.drawRange;
    return [start, Math.min(this.points.count, start + count)];
  }

  describe(index) {
    const scan = this.points.scans[index], number = this.points.planes[index];
    const residual = this.points.residuals[index];
    const parts = [scan < 0 ? 'the drone' : `scan ${this.scene.scans[scan].id}`];
    if (number < 0) return [...parts, 'no plane'];
    const plane = this.scene.planes.find((p) => p[0] === scan && p[1] === number);
    parts.push(`plane ${number}` +
      (plane ? ` (${plane[2].toFixed(2)} m², rms ${(1e3 * plane[3]).toFixed(1)} mm)` : ''));
    if (residual !== NO_RESIDUAL) {
      parts.push(`${(1e3 * residual * this.scene.residual_step).toFixed(1)} mm off it`);
    }
    return parts;
  }

  sayPoint(index) {
    const at = Array.from(this.points.positions.subarray(3 * index, 3 * index + 3));
    const parts = this.describe(index);
    parts.push(`at ${this.frame.toWorld(at).map((v) => v.toFixed(2)).join(', ')} m`);
    if (this.picked !== null) {
      const away = Math.hypot(...at.map((v, axis) => v - this.picked[axis]));
      parts.push(`${away.toFixed(2)} m from the point before`);
    }
    this.picked = at;
    this.stage.mark.position.set(...at);
    this.stage.mark.visible = true;
    this.stage.draw();
    const scan = this.points.scans[index];
    const text = parts.join(' · ');
    this.panel.say(text[0].toUpperCase() + text.slice(1) + '.',
      scan < 0 ? [] : [['Show this scan', () => this.showScan(scan, null)]]);
    this.box.dataset.picked = `${scan} ${this.points.planes[index]}`;
  }
}
