// Starts the view when it comes near the window, or when a table asks for it.
import {readPoints, readScene} from './data.js';
import {connectTables} from './tables.js';
import {Viewer} from './viewer.js';

const box = document.getElementById('viewer');
let starting = null;

function explain(error) {
  const missing = typeof DecompressionStream === 'undefined' || /WebGL/.test(String(error));
  const text = document.createElement('p');
  text.className = 'note';
  text.textContent = missing
    ? 'This browser cannot draw the 3-D view: it needs WebGL, in a browser of 2023 or later.'
    : `The 3-D view cannot be shown: ${error.message}`;
  box.replaceChildren(text);
  box.dataset.state = 'failed';
}

async function start() {
  box.dataset.state = 'loading';
  try {
    const scene = readScene();
    const viewer = new Viewer(box, scene, await readPoints(scene));
    box.dataset.state = 'ready';
    return viewer;
  } catch (error) {
    explain(error);
    return null;
  }
}

function started() {
  starting ??= start();
  return starting;
}

async function show(kind, index, origin) {
  box.scrollIntoView({block: 'start'});
  (await started())?.show(kind, index, origin);
}

const watcher = new IntersectionObserver((entries) => {
  if (!entries.some((entry) => entry.isIntersecting)) return;
  watcher.disconnect();
  started();
}, {rootMargin: '200px'});
watcher.observe(box);
connectTables(show);
