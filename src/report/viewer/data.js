// What the page carries for the view: a scene as JSON, and points as packed columns. The layout is
// described in ../viewer_points.h.

const NO_PLANE = 65535;
export const NO_RESIDUAL = -128;

export function readScene() {
  return JSON.parse(document.getElementById('viewer-scene').textContent);
}

function bytesOfBase64(text) {
  const binary = atob(text);
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < binary.length; i++) bytes[i] = binary.charCodeAt(i);
  return bytes;
}

async function inflate(bytes) {
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('deflate'));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

// A column of differences, low bytes first, then high bytes.
function sumColumn(bytes, start, count) {
  const values = new Uint16Array(count);
  let value = 0;
  for (let i = 0; i < count; i++) {
    value = (value + bytes[start + i] + 256 * bytes[start + count + i]) & 65535;
    values[i] = value;
  }
  return values;
}

// Metres from the middle of the box: small numbers, whatever the site's coordinates.
function placePoints(scene, columns) {
  const count = scene.count;
  const positions = new Float32Array(3 * count);
  for (let axis = 0; axis < 3; axis++) {
    const step = scene.extent[axis] / 65535, half = scene.extent[axis] / 2;
    for (let i = 0; i < count; i++) positions[3 * i + axis] = columns[axis][i] * step - half;
  }
  return positions;
}

function scanOfEach(scene) {
  const scans = new Int16Array(scene.count);
  let at = 0;
  for (const [scan, count] of scene.runs) {
    scans.fill(scan, at, at + count);
    at += count;
  }
  return scans;
}

/// Positions (from the middle of the box), rgb, scan (-1: the drone's), plane (-1: none) and
/// residual (steps) of each point.
export async function readPoints(scene) {
  const packed = document.getElementById('viewer-points');
  const bytes = await inflate(bytesOfBase64(packed.textContent.trim()));
  packed.remove();
  const count = scene.count;
  const columns = [0, 2, 4, 6].map((k) => sumColumn(bytes, k * count, count));
  const rgb = new Uint8Array(3 * count);
  for (let channel = 0; channel < 3; channel++) {
    for (let i = 0; i < count; i++) rgb[3 * i + channel] = bytes[(8 + channel) * count + i];
  }
  return {
    count,
    positions: placePoints(scene, columns),
    rgb,
    scans: scanOfEach(scene),
    planes: Int32Array.from(columns[3], (plane) => (plane === NO_PLANE ? -1 : plane)),
    residuals: new Int8Array(bytes.buffer, bytes.byteOffset + 11 * count, count),
  };
}

/// From the world to the view's coordinates, and back.
export function frameOf(scene) {
  const middle = scene.low.map((low, axis) => low + scene.extent[axis] / 2);
  return {
    toView: (p) => p.map((x, axis) => x - middle[axis]),
    toWorld: (p) => p.map((x, axis) => x + middle[axis]),
  };
}
