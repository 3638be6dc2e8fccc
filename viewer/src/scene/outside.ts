/** Where a point lies to a surface of triangles. */
import * as THREE from 'three';

/**
 * The nearest point of the surface where `x` lies outside it, by the solid angle of all triangles: a closed surface takes
 * up 4 pi around a point inside it and nothing around one outside.
 * @param positions (n, 3) @param triangles (m, 3)
 */
export function outside(
  x: THREE.Vector3,
  positions: Float32Array,
  triangles: Int32Array,
): THREE.Vector3 | undefined {
  const corners = [0, 1, 2].map(() => new THREE.Vector3()) as [THREE.Vector3, THREE.Vector3, THREE.Vector3];
  const [a, b, c] = corners;
  const triangle = new THREE.Triangle(a, b, c);
  const [near, nearest, origin] = [new THREE.Vector3(), new THREE.Vector3(), new THREE.Vector3()];
  let angle = 0;
  let least = Infinity;
  for (let t = 0; t < triangles.length; t += 3) {
    corners.forEach((corner, k) => corner.fromArray(positions, 3 * triangles[t + k]!).sub(x));
    triangle.closestPointToPoint(origin, near);
    if (near.lengthSq() < least) {
      least = near.lengthSq();
      nearest.copy(near);
    }
    // Van Oosterom and Strackee, IEEE Transactions on Biomedical Engineering 30 (1983), 125.
    const [la, lb, lc] = [a.length(), b.length(), c.length()];
    angle +=
      2 *
      Math.atan2(
        a.dot(near.crossVectors(b, c)),
        la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb,
      );
  }
  return least < Infinity && Math.abs(angle) < 2 * Math.PI ? nearest.add(x) : undefined;
}
