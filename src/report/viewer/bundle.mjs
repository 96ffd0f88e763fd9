// Bundles the viewer with three.js into one minified script: node bundle.mjs OUTPUT.js
import {readFileSync} from 'node:fs';
import {dirname, join} from 'node:path';
import {fileURLToPath} from 'node:url';
import {build} from 'esbuild';

const folder = dirname(fileURLToPath(import.meta.url));
const licence = readFileSync(join(folder, 'node_modules/three/LICENSE'), 'utf8').trim();

await build({
  entryPoints: [join(folder, 'main.js')],
  outfile: process.argv[2] ?? join(folder, 'viewer.js'),
  bundle: true,
  minify: true,
  format: 'esm',
  target: ['es2022'],
  charset: 'ascii',
  legalComments: 'inline',
  // three.js is under the MIT licence, whose text has to go with every copy.
  banner: {js: `/*! This script contains three.js.\n\n${licence}\n*/`},
  logLevel: 'warning',
});
