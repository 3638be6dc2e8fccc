/** Simple shapes of the made-up run. z is up. */

export interface Shape {
  positions: Float32Array<ArrayBuffer>;
  triangles: Int32Array<ArrayBuffer>;
}

/** A grid of (n + 1)² vertices over [-1, 1]², at z = 0. */
export function sheet(n: number): Shape {
  const positions = new Float32Array((n + 1) * (n + 1) * 3);
  const triangles = new Int32Array(n * n * 6);
  let t = 0;
  for (let j = 0; j <= n; ++j)
    for (let i = 0; i <= n; ++i) positions.set([(2 * i) / n - 1, (2 * j) / n - 1, 0], 3 * (j * (n + 1) + i));
  for (let j = 0; j < n; ++j)
    for (let i = 0; i < n; ++i) {
      const a = j * (n + 1) + i;
      triangles.set([a, a + 1, a + n + 2, a, a + n + 2, a + n + 1], t);
      t += 6;
    }
  return { positions, triangles };
}

/** The box [-x, x] × [-y, y] × [-z, z] with eight shared corners, whose edges the page must keep sharp. */
export function box(x: number, y: number, z: number): Shape {
  const positions = new Float32Array(24);
  for (let i = 0; i < 8; ++i) positions.set([i & 1 ? x : -x, i & 2 ? y : -y, i & 4 ? z : -z], 3 * i);
  const quads = [
    [0, 2, 3, 1],
    [4, 5, 7, 6],
    [0, 1, 5, 4],
    [2, 6, 7, 3],
    [0, 4, 6, 2],
    [1, 3, 7, 5],
  ] as const;
  return { positions, triangles: new Int32Array(quads.flatMap(([a, b, c, d]) => [a, b, c, a, c, d])) };
}

/** A sphere of radius 1 from a subdivided octahedron. */
export function sphere(levels: number): Shape {
  let points: number[][] = [
    [1, 0, 0],
    [-1, 0, 0],
    [0, 1, 0],
    [0, -1, 0],
    [0, 0, 1],
    [0, 0, -1],
  ];
  let faces: number[][] = [
    [0, 2, 4],
    [2, 1, 4],
    [1, 3, 4],
    [3, 0, 4],
    [2, 0, 5],
    [1, 2, 5],
    [3, 1, 5],
    [0, 3, 5],
  ];
  for (let level = 0; level < levels; ++level) {
    const middle = new Map<string, number>();
    const between = (a: number, b: number) => {
      const key = a < b ? `${a},${b}` : `${b},${a}`;
      const known = middle.get(key);
      if (known !== undefined) return known;
      const p = points[a]!.map((x, k) => x + points[b]![k]!);
      const length = Math.hypot(...p);
      points.push(p.map((x) => x / length));
      middle.set(key, points.length - 1);
      return points.length - 1;
    };
    faces = faces.flatMap(([a, b, c]) => {
      const ab = between(a!, b!);
      const bc = between(b!, c!);
      const ca = between(c!, a!);
      return [
        [a!, ab, ca],
        [ab, b!, bc],
        [ca, bc, c!],
        [ab, bc, ca],
      ];
    });
  }
  return { positions: new Float32Array(points.flat()), triangles: new Int32Array(faces.flat()) };
}
