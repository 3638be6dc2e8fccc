import { expect, test } from 'vitest';
import * as THREE from 'three';
import { Ground } from '../src/scene/ground';

/** A ground under bodies between two heights. */
function placed(standing: boolean, low: number, high: number): Ground {
  const ground = new Ground();
  ground.standing = standing;
  const box = new THREE.Box3(new THREE.Vector3(-1, -1, low), new THREE.Vector3(1, 1, high));
  ground.place(box.getCenter(new THREE.Vector3()), 1, box);
  return ground;
}

test('with obstacles the ground lies under the bodies and takes their shadows', () => {
  const { object } = placed(true, -3, -2);
  expect(object.visible && object.children.every((o) => o.visible)).toBe(true);
  expect(object.position.z).toBeCloseTo(-3, 2);
});

test('without obstacles there is a grid at zero at most, under all bodies, and no shadow', () => {
  const { object } = placed(false, 0.2, 1);
  expect(object.visible).toBe(true);
  expect(object.position.z).toBe(0);
  expect(object.children.map((o) => o.visible)).toEqual([false, true]);
  expect(placed(false, -3, 1).object.visible).toBe(false);
  expect(placed(false, 20, 21).object.visible).toBe(false);
});
