import { expect, test } from 'vitest';
import { Player } from '../src/player';

const player = (times: number[]) => {
  const p = new Player();
  p.setTimes(times);
  return p;
};

test('playing follows the times of the frames, not their numbers', () => {
  const p = player([0, 0.1, 0.5, 1]);
  p.toggle();
  p.advance(0.3);
  expect(p.frame).toBe(1);
  p.advance(0.25);
  expect(p.frame).toBe(2);
});

test('speed scales time', () => {
  const p = player([0, 1, 2, 3]);
  p.setSpeed(0.5);
  p.toggle();
  p.advance(2.1);
  expect(p.frame).toBe(1);
});

test('looping wraps, not looping stops at the last frame and plays from the start again', () => {
  const p = player([0, 1, 2]);
  p.toggle();
  p.advance(2.5);
  expect([p.frame, p.playing]).toEqual([0, true]);
  p.setLoop(false);
  p.advance(5);
  expect([p.frame, p.playing]).toEqual([2, false]);
  p.toggle();
  expect([p.frame, p.playing]).toEqual([0, true]);
});

test('steps stop at the ends and pause', () => {
  const p = player([0, 1, 2]);
  p.toggle();
  p.step(-5);
  expect([p.frame, p.playing]).toEqual([0, false]);
  p.step(100);
  expect(p.frame).toBe(2);
});

test('a run of no frames, or of one, cannot be played and breaks nothing', () => {
  for (const times of [[], [0]]) {
    const p = player(times);
    p.toggle();
    p.advance(1);
    p.step(1);
    expect([p.frame, p.playing, p.time()]).toEqual([0, false, 0]);
  }
});

test('a growing run keeps its place; a shorter one moves it to the end', () => {
  const p = player([0, 1]);
  p.seek(1);
  p.setTimes([0, 1, 2, 3]);
  expect(p.frame).toBe(1);
  p.seek(3);
  p.setTimes([0, 1]);
  expect(p.frame).toBe(1);
});

test('the frame at a time is the last that does not lie after it', () => {
  const times = [0, 0.25, 0.5, 2];
  const p = player(times);
  for (let t = -0.5; t < 3; t += 0.01) {
    const slow = times.filter((x) => x <= t + 1e-12).length - 1; // by counting
    expect(p.frameAt(t)).toBe(Math.max(0, slow));
  }
});

test('listeners hear until they leave', () => {
  const p = player([0, 1]);
  let heard = 0;
  const leave = p.onChange(() => ++heard);
  p.seek(1);
  leave();
  p.seek(0);
  expect(heard).toBe(1);
});
