// The colour of every point by one of its properties, and the legend that goes with it. Colours
// are triples of 0 to 255.
import {NO_RESIDUAL} from './data.js';

export const MODES = [
  ['rgb', 'colour'],
  ['source', 'laser or drone'],
  ['scan', 'scan'],
  ['plane', 'plane'],
  ['height', 'height'],
  ['residual', 'distance to its plane'],
];

const GREY = [140, 146, 154];
const LASER = [43, 124, 203];
const DRONE = [222, 140, 48];
export const TARGET = [43, 124, 203];
export const SOURCE = [226, 96, 30];
const HEIGHTS = [[72, 33, 115], [56, 88, 140], [33, 145, 140], [94, 201, 98], [240, 210, 40]];
const SIGNED = [[33, 102, 172], [103, 169, 207], [205, 205, 205], [239, 138, 98], [178, 24, 43]];

function ramp(stops, share) {
  const at = Math.min(Math.max(share, 0), 1) * (stops.length - 1);
  const k = Math.min(Math.floor(at), stops.length - 2);
  return stops[k].map((value, c) => value + (at - k) * (stops[k + 1][c] - value));
}

// Hues a golden section apart: neighbours in number are far apart in colour.
function distinct(number) {
  const hue = (((number + 1) * 0.618033988749895) % 1) * 6;
  const light = 205 - 40 * (number % 2);
  return [5, 3, 1].map((shift) => {
    const k = (shift + hue) % 6;
    return light - 130 * Math.max(0, Math.min(k, 4 - k, 1));
  });
}

function quantile(sorted, share) {
  return sorted[Math.round(share * (sorted.length - 1))];
}

/// The heights (of the view's frame) that nearly all points lie between.
export function usualHeights(points) {
  const step = Math.max(1, Math.floor(points.count / 20000));
  const heights = [];
  for (let i = 0; i < points.count; i += step) heights.push(points.positions[3 * i + 2]);
  heights.sort((a, b) => a - b);
  if (heights.length === 0) return [0, 1];
  return [quantile(heights, 0.01), quantile(heights, 0.99)];
}

function cached(make) {
  const known = new Map();
  return (number) => {
    if (!known.has(number)) known.set(number, make(number));
    return known.get(number);
  };
}

// The function from the index of a point to its colour.
function colourOf(mode, points, heights) {
  const scan = cached(distinct);
  const plane = cached(distinct);
  const height = cached((k) => ramp(HEIGHTS, k / 255));
  const signed = cached((k) => ramp(SIGNED, 0.5 + k / 254));
  const [low, high] = heights;
  const perMetre = 255 / Math.max(high - low, 1e-3);
  switch (mode) {
    case 'source':
      return (i) => (points.scans[i] < 0 ? DRONE : LASER);
    case 'scan':
      return (i) => (points.scans[i] < 0 ? GREY : scan(points.scans[i]));
    case 'plane':
      return (i) => (points.planes[i] < 0 ? GREY : plane(points.planes[i] + 7 * points.scans[i]));
    case 'height':
      return (i) => height(Math.round((points.positions[3 * i + 2] - low) * perMetre));
    case 'residual':
      return (i) =>
        points.residuals[i] === NO_RESIDUAL ? GREY : signed(points.residuals[i]);
    default:
      return (i) => points.rgb.subarray(3 * i, 3 * i + 3);
  }
}

// What is not chosen fades towards the background.
function fade(colour, background) {
  return colour.map((value, c) => 0.12 * value + 0.88 * background[c]);
}

/// Fills `colours`. `choice` is what is chosen in the tables: null, {scan} or {target, source},
/// where a target of -1 is a drone map.
export function paint(colours, mode, points, heights, choice, background) {
  const of = colourOf(mode, points, heights);
  for (let i = 0; i < points.count; i++) {
    let colour = of(i);
    if (choice !== null) {
      const scan = points.scans[i];
      if ('scan' in choice) {
        if (scan !== choice.scan) colour = fade([...colour], background);
      } else if (scan === choice.source) {
        colour = SOURCE;
      } else if (scan !== choice.target) {
        colour = fade([...colour], background);
      } else if (scan >= 0) {
        colour = TARGET;
      }
    }
    colours[3 * i] = colour[0];
    colours[3 * i + 1] = colour[1];
    colours[3 * i + 2] = colour[2];
  }
}

const css = (colour) => `rgb(${colour.map(Math.round).join(',')})`;
const gradient = (stops) => `linear-gradient(90deg, ${stops.map(css).join(',')})`;

/// Entries of the legend: {text, background (CSS), wide}.
export function legendOf(mode, scene, heights, toWorld) {
  if (mode === 'source') {
    return [{text: 'laser', background: css(LASER)}, {text: 'drone', background: css(DRONE)}];
  }
  if (mode === 'height') {
    const [low, high] = heights.map((z) => toWorld([0, 0, z])[2].toFixed(1));
    return [{text: `${low} to ${high} m`, background: gradient(HEIGHTS), wide: true}];
  }
  if (mode === 'residual') {
    const most = (127e3 * scene.residual_step).toFixed(0);
    return [
      {text: `−${most} to ${most} mm`, background: gradient(SIGNED), wide: true},
      {text: 'no plane', background: css(GREY)},
    ];
  }
  if (mode === 'plane') return [{text: 'no plane', background: css(GREY)}];
  if (mode === 'scan') {
    const drone = scene.maps.length > 0 ? [{text: 'drone', background: css(GREY)}] : [];
    return [{text: 'one colour for each scan'}, ...drone];
  }
  return [];
}
