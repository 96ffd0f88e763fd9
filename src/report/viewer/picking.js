// Which point, or which scan's marker, is under the finger.
import {Matrix4, Vector3} from 'three';

const REACH = 10;  // CSS pixels

/// Calls found(event) for clicks and taps that are no drags.
export function onClick(canvas, found) {
  let start = null;
  canvas.addEventListener('pointerdown', (event) => {
    start = event.isPrimary ? [event.clientX, event.clientY] : null;
  });
  canvas.addEventListener('pointerup', (event) => {
    if (start === null || event.button !== 0) return;
    if (Math.hypot(event.clientX - start[0], event.clientY - start[1]) < 5) found(event);
    start = null;
  });
}

function clickInPixels(event, canvas) {
  const box = canvas.getBoundingClientRect();
  return {x: event.clientX - box.left, y: event.clientY - box.top, w: box.width, h: box.height};
}

/// The scan whose marker is there, or -1.
export function pickMarker(event, stage, canvas) {
  if (!stage.ways.visible) return -1;
  const click = clickInPixels(event, canvas);
  const at = new Vector3();
  let best = -1, nearest = REACH;
  for (const marker of stage.ways.children) {
    if (!marker.isMesh) continue;
    at.copy(marker.position).project(stage.camera);
    if (at.z > 1) continue;
    const distance =
      Math.hypot((at.x + 1) / 2 * click.w - click.x, (1 - at.y) / 2 * click.h - click.y);
    if (distance < nearest) [best, nearest] = [marker.userData.scan, distance];
  }
  return best;
}

/// The index of the point in front among those near the click, or -1. `drawn` are the first and
/// one past the last index of the points that are drawn.
export function pickPoint(event, stage, canvas, points, drawn) {
  const click = clickInPixels(event, canvas);
  stage.camera.updateMatrixWorld();
  const m = new Matrix4()
    .multiplyMatrices(stage.camera.projectionMatrix, stage.camera.matrixWorldInverse).elements;
  const p = points.positions;
  let best = -1, least = Infinity;
  for (let i = drawn[0]; i < drawn[1]; i++) {
    const x = p[3 * i], y = p[3 * i + 1], z = p[3 * i + 2];
    if (z > stage.clip.constant) continue;
    const w = m[3] * x + m[7] * y + m[11] * z + m[15];
    if (w <= 0) continue;
    const right = ((m[0] * x + m[4] * y + m[8] * z + m[12]) / w + 1) / 2 * click.w - click.x;
    if (Math.abs(right) > REACH) continue;
    const down = (1 - (m[1] * x + m[5] * y + m[9] * z + m[13]) / w) / 2 * click.h - click.y;
    const away = Math.hypot(right, down);
    // In front counts, but a point right under the click beats one beside it that is a bit nearer.
    const cost = w * (1 + 0.02 * away);
    if (away < REACH && cost < least) [best, least] = [i, cost];
  }
  return best;
}
