/** What the surface of 25,000 shaken particles takes: npx esbuild dev/surface_cost.ts --bundle --platform=node | node */
import { fluidSurface } from '../src/surface/fluid_surface';

const radius = 0.01;
const points = new Float32Array(3 * 25_000);
for (let p = 0; p < points.length / 3; ++p)
  [p % 50, Math.floor(p / 50) % 25, Math.floor(p / 1250)].forEach((n, axis) => {
    points[3 * p + axis] = (2 * n + 1 + 0.5 * Math.sin(7 * p + 3 * axis * p)) * radius;
  });
for (let round = 0; round < 8; ++round) {
  const start = process.cpuUsage();
  const { cells } = fluidSurface(points, radius);
  const { user, system } = process.cpuUsage(start);
  console.log(`${((user + system) / 1000).toFixed(0)} ms of processor time, ${cells.length / 3} triangles`);
}
