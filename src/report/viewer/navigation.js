// Moving about: mouse, touch, keyboard. The page must stay scrollable: the wheel and single fingers
// move the view only while it has the focus.
import {Vector3} from 'three';
import {OrbitControls} from 'three/addons/controls/OrbitControls.js';

const TURN = 0.12;   // radians for a key
const ZOOM = 1.2;    // for a key
const SHIFT = 0.08;  // of the distance, for a key

export class Navigation {
  constructor(stage, canvas, onMove) {
    this.stage = stage;
    this.canvas = canvas;
    this.controls = new OrbitControls(stage.camera, canvas);
    this.controls.enableDamping = false;
    this.controls.screenSpacePanning = true;
    this.controls.zoomToCursor = true;
    this.controls.maxPolarAngle = Math.PI * 0.98;
    this.controls.addEventListener('change', () => {
      onMove();
      stage.draw();
    });
    this.watchFocus();
    canvas.addEventListener('keydown', (event) => this.onKey(event));
  }

  watchFocus() {
    const update = () => {
      const active = document.activeElement === this.canvas;
      this.controls.enableZoom = active;
      this.canvas.style.touchAction = active ? 'none' : 'pan-y';
      this.controls.enabled = active || !this.touching;
    };
    // Capture: before the controls see the finger.
    this.canvas.addEventListener('pointerdown', (event) => {
      this.touching = event.pointerType === 'touch';
      update();
    }, {capture: true});
    this.canvas.addEventListener('pointerup', () => this.canvas.focus({preventScroll: true}));
    this.canvas.addEventListener('focus', update);
    this.canvas.addEventListener('blur', update);
    update();
  }

  onKey(event) {
    const arrows = {
      ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1],
    };
    if (event.key in arrows) {
      const [x, y] = arrows[event.key];
      if (event.shiftKey) this.shift(x, y);
      else this.turn(x * TURN, y * TURN);
    } else if (event.key === '+' || event.key === '=') {
      this.zoom(1 / ZOOM);
    } else if (event.key === '-') {
      this.zoom(ZOOM);
    } else {
      return;
    }
    event.preventDefault();
  }

  turn(aside, up) {
    const offset = this.stage.camera.position.clone().sub(this.controls.target);
    const distance = offset.length();
    const azimuth = Math.atan2(offset.y, offset.x) + aside;
    const elevation = Math.min(
      Math.max(Math.asin(offset.z / distance) + up, -1.4), Math.PI / 2 - 0.01);
    offset.set(
      distance * Math.cos(elevation) * Math.cos(azimuth),
      distance * Math.cos(elevation) * Math.sin(azimuth), distance * Math.sin(elevation));
    this.place(this.controls.target, offset);
  }

  zoom(factor) {
    const offset = this.stage.camera.position.clone().sub(this.controls.target);
    this.place(this.controls.target, offset.multiplyScalar(factor));
  }

  shift(x, y) {
    const offset = this.stage.camera.position.clone().sub(this.controls.target);
    const right = new Vector3(1, 0, 0).applyQuaternion(this.stage.camera.quaternion);
    const ahead = new Vector3(0, 0, 1).cross(right);
    const by = right.multiplyScalar(x).addScaledVector(ahead, y);
    this.place(
      this.controls.target.clone().addScaledVector(by, SHIFT * offset.length()), offset);
  }

  place(target, offset) {
    this.controls.target.copy(target);
    this.stage.camera.position.copy(target).add(offset);
    this.controls.update();
    this.stage.draw();
  }

  /// Looks at a place (of the view's frame) from `distance` in a direction, given or as it is now.
  lookAt(target, distance, direction) {
    const goal = new Vector3(...target);
    const from = direction ? new Vector3(...direction)
                           : this.stage.camera.position.clone().sub(this.controls.target);
    from.setLength(distance);
    if (matchMedia('(prefers-reduced-motion: reduce)').matches) return this.place(goal, from);
    this.glide(goal, from);
  }

  glide(goal, offset) {
    const target = this.controls.target.clone();
    const start = this.stage.camera.position.clone().sub(target);
    const begin = performance.now(), duration = 350;
    const step = () => {
      const share = Math.min(1, (performance.now() - begin) / duration);
      const eased = share * share * (3 - 2 * share);
      const between = start.clone().lerp(offset, eased);
      this.place(target.clone().lerp(goal, eased), between);
      if (share < 1) requestAnimationFrame(step);
    };
    step();
  }
}
