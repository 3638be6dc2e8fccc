/** How much of the world the picture should show. */
import * as THREE from 'three';

/** Box of the finite points of a list, empty if there are none. */
export function boxOf(positions: Float32Array): THREE.Box3 {
  const box = new THREE.Box3();
  const p = new THREE.Vector3();
  for (let i = 0; i + 2 < positions.length; i += 3) {
    p.set(positions[i]!, positions[i + 1]!, positions[i + 2]!);
    if (Number.isFinite(p.x + p.y + p.z)) box.expandByPoint(p);
  }
  return box;
}

const kStray = 0.02; // share of the points at each end of an axis that may lie far from the rest

/** Box of loose points without those few that flew far from the rest; all of them where none did. */
export function boxWithoutStrays(positions: Float32Array): THREE.Box3 {
  const whole = boxOf(positions);
  const out = Math.floor((kStray * positions.length) / 3);
  if (out === 0) return whole;
  const inner = new THREE.Box3();
  for (let a = 0; a < 3; ++a) {
    const along = positions.filter((x, i) => i % 3 === a && Number.isFinite(x)).sort();
    inner.min.setComponent(a, along[out] ?? NaN);
    inner.max.setComponent(a, along[along.length - 1 - out] ?? NaN);
  }
  return diagonal(inner) < 0.8 * diagonal(whole) ? inner : whole;
}

const diagonal = (box: THREE.Box3) => (box.isEmpty() ? 0 : box.min.distanceTo(box.max));

const kScattered = 4; // times their extent at the start: bodies that wide apart do not all matter
const kTravel = 60; // times their extent at the start: how far bodies that stay together are followed
const kWide = 1.5; // times the extent of what moves: fixed bodies up to so wide are of its scale
const kAround = 1.5; // extents at the start by which what scattered is followed

/**
 * Box to frame: the moving bodies over some frames, the first of which sets the scale. Bodies that stay together are
 * shown along their whole way, up to kTravel; a body shot far away does not shrink the rest to a dot. Of what is fixed,
 * all is shown if it is of that scale, else the part near by.
 * @param start  box of the moving bodies in the first frame of the run: what has scattered since is cut to its surroundings
 */
export function framing(moving: THREE.Box3[], fixed: THREE.Box3[], start = new THREE.Box3()): THREE.Box3 {
  const box = new THREE.Box3();
  const around = start.clone().expandByScalar(kAround * diagonal(start));
  const first = diagonal(start.isEmpty() ? (moving.find((m) => !m.isEmpty()) ?? start) : start);
  for (const m of moving) {
    const scattered = diagonal(m) > kScattered * first;
    const own = scattered && m.intersectsBox(around) ? m.clone().intersect(around) : m;
    const most = scattered ? kScattered * diagonal(box) : kTravel * first;
    if (box.isEmpty() || diagonal(box.clone().union(own)) < most) box.union(own);
  }
  const scale = diagonal(box);
  for (const f of fixed) {
    if (f.isEmpty()) continue;
    if (scale === 0 || diagonal(f) < kWide * scale) {
      box.union(f);
      continue;
    }
    const near = box
      .clone()
      .expandByScalar(0.06 * scale)
      .intersect(f);
    if (!near.isEmpty()) box.union(near);
  }
  return box;
}
