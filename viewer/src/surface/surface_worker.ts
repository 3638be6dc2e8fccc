/** Makes surfaces of particles beside the page, which keeps drawing meanwhile. */
import { vertexNormals } from '../scene/normals';
import { fluidSurface } from './fluid_surface';

self.onmessage = (event: MessageEvent<{ points: Float32Array; radius: number }>) => {
  const { positions, cells } = fluidSurface(event.data.points, event.data.radius);
  const normals = vertexNormals(positions, cells);
  (self as unknown as Worker).postMessage({ positions, cells, normals }, [
    positions.buffer,
    cells.buffer,
    normals.buffer,
  ]);
};
