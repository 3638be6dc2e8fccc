import { expect, test } from 'vitest';
import { box, sheet, sphere, type Shape } from '../dev/shapes';
import { splitAtCreases, updateShading, vertexNormals } from '../src/scene/normals';

const kCrease = (38 * Math.PI) / 180;

function shade(shape: Shape) {
  const mesh = splitAtCreases(shape.positions, shape.triangles, kCrease);
  const positions = new Float32Array(mesh.source.length * 3);
  const normals = new Float32Array(mesh.source.length * 3);
  updateShading(mesh, shape.positions, positions, normals);
  return { mesh, positions, normals };
}

test('a box falls into six flat faces with their own normals', () => {
  const { mesh, normals } = shade(box(1, 2, 3));
  expect(mesh.source.length).toBe(24);
  for (let i = 0; i < normals.length; i += 3) {
    const sizes = [...normals.slice(i, i + 3)].map(Math.abs).sort();
    expect(sizes[2]).toBeCloseTo(1, 6);
    expect(sizes[1]).toBeCloseTo(0, 6);
  }
});

test('a sphere stays whole and its normals point along its radii', () => {
  const shape = sphere(3);
  const { mesh, positions, normals } = shade(shape);
  expect(mesh.source.length).toBe(shape.positions.length / 3);
  for (let i = 0; i < normals.length; i += 3) {
    let dot = 0;
    for (let k = 0; k < 3; ++k) dot += positions[i + k]! * normals[i + k]!;
    expect(dot).toBeGreaterThan(0.995);
  }
});

test('splitting keeps every triangle where it was', () => {
  for (const shape of [box(1, 1, 1), sphere(2), sheet(5)]) {
    const { mesh } = shade(shape);
    expect([...mesh.index].map((i) => mesh.source[i])).toEqual([...shape.triangles]);
  }
});

test('a sheet that folds later is still shaded smoothly: the split does not change', () => {
  const shape = sheet(8);
  const mesh = splitAtCreases(shape.positions, shape.triangles, kCrease);
  expect(mesh.source.length).toBe(81);
});

test('triangles without area, and no triangles, give normals without not-a-number', () => {
  const flat = { positions: new Float32Array(9), triangles: new Int32Array([0, 1, 2]) };
  expect([...shade(flat).normals].every(Number.isFinite)).toBe(true);
  expect(shade({ positions: new Float32Array(0), triangles: new Int32Array(0) }).mesh.source.length).toBe(0);
});

test('the normals of a surface of its own for one frame point along the radii of a sphere', () => {
  const shape = sphere(3);
  const normals = vertexNormals(shape.positions, shape.triangles);
  expect(normals.length).toBe(shape.positions.length);
  for (let i = 0; i < normals.length; i += 3) {
    let dot = 0;
    for (let k = 0; k < 3; ++k) dot += normals[i + k]! * shape.positions[i + k]!;
    expect(dot).toBeGreaterThan(0.99);
  }
});
