/**
 * Shading of moving triangle meshes. Vertices are split once, where the first frame has a crease; the split list then
 * serves every frame, so that edges never flicker between sharp and smooth.
 */

export interface SplitMesh {
  source: Int32Array; // split vertex -> vertex of the body
  index: Uint32Array; // triangles over split vertices, (nt, 3)
}

/** Area-weighted normals of the triangles, (nt, 3), of length twice their area. */
function faceNormals(positions: Float32Array, triangles: ArrayLike<number>): Float32Array {
  const out = new Float32Array(triangles.length);
  for (let t = 0; t < triangles.length; t += 3) {
    const a = 3 * triangles[t]!;
    const b = 3 * triangles[t + 1]!;
    const c = 3 * triangles[t + 2]!;
    const ux = positions[b]! - positions[a]!;
    const uy = positions[b + 1]! - positions[a + 1]!;
    const uz = positions[b + 2]! - positions[a + 2]!;
    const vx = positions[c]! - positions[a]!;
    const vy = positions[c + 1]! - positions[a + 1]!;
    const vz = positions[c + 2]! - positions[a + 2]!;
    out[t] = uy * vz - uz * vy;
    out[t + 1] = uz * vx - ux * vz;
    out[t + 2] = ux * vy - uy * vx;
  }
  return out;
}

/**
 * Splits the vertices so that triangles meeting along an edge share them only when their normals differ by less than
 * the given angle. Around a vertex, triangles are grouped by walking over such edges (union of neighbours).
 * @param crease [rad]
 */
export function splitAtCreases(positions: Float32Array, triangles: Int32Array, crease: number): SplitMesh {
  const normals = faceNormals(positions, triangles);
  const faces = triangles.length / 3;
  const limit = Math.cos(crease);
  const smooth = (f: number, g: number) => {
    let dot = 0;
    let ff = 0;
    let gg = 0;
    for (let k = 0; k < 3; ++k) {
      const x = normals[3 * f + k]!;
      const y = normals[3 * g + k]!;
      dot += x * y;
      ff += x * x;
      gg += y * y;
    }
    return ff === 0 || gg === 0 || dot >= limit * Math.sqrt(ff * gg);
  };

  // Corners are united across smooth edges; each resulting set is one split vertex.
  const parent = Int32Array.from({ length: 3 * faces }, (_, i) => i);
  const root = (i: number) => {
    while (parent[i] !== i) i = parent[i] = parent[parent[i]!]!;
    return i;
  };
  const unite = (a: number, b: number) => {
    const ra = root(a);
    const rb = root(b);
    if (ra !== rb) parent[Math.max(ra, rb)] = Math.min(ra, rb);
  };
  const vertices = positions.length / 3;
  const cornerAt = new Map<number, number>(); // edge -> corner that starts it, in the face first seen
  for (let c = 0; c < 3 * faces; ++c) {
    const next = c % 3 === 2 ? c - 2 : c + 1;
    const a = triangles[c]!;
    const b = triangles[next]!;
    const key = Math.min(a, b) * vertices + Math.max(a, b);
    const other = cornerAt.get(key);
    if (other === undefined) {
      cornerAt.set(key, c);
      continue;
    }
    const otherNext = other % 3 === 2 ? other - 2 : other + 1;
    if (!smooth(Math.floor(c / 3), Math.floor(other / 3))) continue;
    if (triangles[other] === a) {
      unite(c, other);
      unite(next, otherNext);
    } else {
      unite(c, otherNext);
      unite(next, other);
    }
  }

  const index = new Uint32Array(3 * faces);
  const source: number[] = [];
  const number = new Int32Array(3 * faces).fill(-1);
  for (let c = 0; c < 3 * faces; ++c) {
    const r = root(c);
    if (number[r] === -1) {
      number[r] = source.length;
      source.push(triangles[c]!);
    }
    index[c] = number[r]!;
  }
  return { source: Int32Array.from(source), index };
}

/** Copies positions to the split vertices and computes their normals, both (n, 3), written in place. */
export function updateShading(
  mesh: SplitMesh,
  positions: Float32Array,
  outPositions: Float32Array,
  outNormals: Float32Array,
) {
  const { source, index } = mesh;
  for (let i = 0, o = 0; i < source.length; ++i, o += 3) {
    const s = 3 * source[i]!;
    outPositions[o] = positions[s]!;
    outPositions[o + 1] = positions[s + 1]!;
    outPositions[o + 2] = positions[s + 2]!;
  }
  vertexNormals(outPositions, index, outNormals);
}

/**
 * Normals of the vertices of a surface, weighted by the areas around them, (nv, 3). One pass over the triangles and no
 * memory of its own: every moving surface comes through here in every frame.
 */
export function vertexNormals(
  positions: Float32Array,
  triangles: Uint32Array | Int32Array,
  out: Float32Array = new Float32Array(positions.length),
): Float32Array {
  out.fill(0);
  for (let t = 0; t < triangles.length; t += 3) {
    const a = 3 * triangles[t]!;
    const b = 3 * triangles[t + 1]!;
    const c = 3 * triangles[t + 2]!;
    const ax = positions[a]!;
    const ay = positions[a + 1]!;
    const az = positions[a + 2]!;
    const ux = positions[b]! - ax;
    const uy = positions[b + 1]! - ay;
    const uz = positions[b + 2]! - az;
    const vx = positions[c]! - ax;
    const vy = positions[c + 1]! - ay;
    const vz = positions[c + 2]! - az;
    const nx = uy * vz - uz * vy;
    const ny = uz * vx - ux * vz;
    const nz = ux * vy - uy * vx;
    out[a]! += nx;
    out[a + 1]! += ny;
    out[a + 2]! += nz;
    out[b]! += nx;
    out[b + 1]! += ny;
    out[b + 2]! += nz;
    out[c]! += nx;
    out[c + 1]! += ny;
    out[c + 2]! += nz;
  }
  for (let i = 0; i < out.length; i += 3) {
    const x = out[i]!;
    const y = out[i + 1]!;
    const z = out[i + 2]!;
    const squared = x * x + y * y + z * z; // Math.hypot takes ten times as long
    const scale = squared > 0 ? 1 / Math.sqrt(squared) : 1;
    out[i] = x * scale;
    out[i + 1] = y * scale;
    out[i + 2] = z * scale;
  }
  return out;
}
