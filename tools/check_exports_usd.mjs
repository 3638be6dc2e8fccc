// Runs inside Node for tools/check_exports.py: opens a USD file with TinyUSDZ and writes, as JSON, every prim it knows, and
// of meshes their points in the world and numbers of faces, at the file's first time.
//   node check_exports_usd.mjs FOLDER_OF_TINYUSDZ FILE.usda OUT.json
import { readFileSync, writeFileSync } from 'node:fs';
import { join, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';

// The package is built for browsers, and looks around for one.
Object.defineProperty(process, 'type', { value: 'renderer' });
globalThis.window = globalThis;

const [folder, file, out] = process.argv.slice(2);
const { default: start } = await import(pathToFileURL(resolve(join(folder, 'tinyusdz.js'))).href);
const { TinyUSDZLoaderNative } = await start({ wasmBinary: readFileSync(join(folder, 'tinyusdz.wasm')) });
const usd = new TinyUSDZLoaderNative();
if (!usd.loadFromBinary(new Uint8Array(readFileSync(file)), file)) throw new Error(usd.error());

const meshes = {};
const prims = [];
/** @param place matrix of the prim in the world, for row vectors, 16 numbers by rows */
function visit(prim, above) {
  const own = prim.localMatrix;
  const place = Array.from({ length: 16 }, (_, n) =>
    [0, 1, 2, 3].reduce((sum, k) => sum + own[(n & ~3) + k] * above[4 * k + (n & 3)], 0),
  );
  prims.push(prim.primName);
  if (prim.nodeType === 'mesh') {
    const { points, faceVertexCounts } = usd.getMesh(prim.contentId);
    const world = [];
    for (let i = 0; i < points.length; i += 3)
      for (let a = 0; a < 3; ++a)
        world.push([0, 1, 2].reduce((sum, k) => sum + points[i + k] * place[4 * k + a], place[12 + a]));
    meshes[prim.primName] = { points: world, faces: faceVertexCounts.length };
  }
  for (const child of prim.children ?? []) visit(child, place);
}
visit(usd.getDefaultRootNode(), [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]);
writeFileSync(out, JSON.stringify({ prims, meshes }));
