import { expect, test } from 'vitest';
import * as THREE from 'three';
import { framing } from '../src/scene/bounds';

const box = (x0: number, x1: number, z0 = 0, z1 = 1) =>
  new THREE.Box3(new THREE.Vector3(x0, 0, z0), new THREE.Vector3(x1, 1, z1));

test('a frame is shown whole', () => {
  expect(framing([box(2, 4)], [], box(0, 2))).toEqual(box(2, 4));
});

test('what went away as a whole is followed', () => {
  expect(framing([box(50, 52)], [], box(0, 2))).toEqual(box(50, 52));
});

test('the whole way of a ball that falls far is shown, but not that of one that flies off', () => {
  const fall = [box(0, 2), box(0, 2, -9, -8), box(0, 2, -20, -19)];
  expect(framing(fall, [], fall[0])).toEqual(box(0, 2, -20, 1));
  const shot = [box(0, 2), box(30, 32), box(5000, 5002), box(9000, 9002)];
  expect(framing(shot, [], shot[0])).toEqual(box(0, 32));
});

test('what was spilled is followed a little way', () => {
  const framed = framing([box(0, 2, -80, 1)], [], box(0, 2));
  expect(framed.max.z).toBe(1);
  expect(framed.min.z).toBeLessThan(-2);
  expect(framed.min.z).toBeGreaterThan(-5);
});

test('what is fixed is shown whole if it is of the scale of what moves, else only near it', () => {
  const ring = box(0, 2.5, 3, 4);
  expect(framing([box(0, 2)], [ring])).toEqual(box(0, 2.5, 0, 4));
  const floor = box(-50, 50, -1, 0);
  const framed = framing([box(0, 2)], [floor]);
  expect(framed.min.x).toBeGreaterThan(-1);
  expect(framed.max.x).toBeLessThan(3);
});

test('the first of some frames sets the scale', () => {
  expect(framing([box(0, 2), box(0, 80), box(1, 3)], [])).toEqual(box(0, 3));
});
