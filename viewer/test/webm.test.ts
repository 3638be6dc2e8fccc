import { expect, test } from 'vitest';
import { Player } from '../src/player';
import { filmPlan } from '../src/ui/capture';
import { webm } from '../src/ui/webm';

/** Elements of some bytes, read by the rules of EBML and not by those of the writer. */
function elements(bytes: Uint8Array): { id: number; content: Uint8Array }[] {
  const out: { id: number; content: Uint8Array }[] = [];
  for (let at = 0; at < bytes.length;) {
    const width = Math.clz32(bytes[at]!) - 23;
    let id = 0;
    for (let i = 0; i < width; ++i) id = id * 256 + bytes[at++]!;
    const digits = Math.clz32(bytes[at]!) - 23;
    let size = bytes[at++]! & (0xff >> digits);
    for (let i = 1; i < digits; ++i) size = size * 256 + bytes[at++]!;
    out.push({ id, content: bytes.subarray(at, at + size) });
    at += size;
  }
  return out;
}

test('a film is made of clusters that start with a key picture, and keeps every picture and its time', async () => {
  const pictures = Array.from({ length: 130 }, (_, k) => ({
    data: Uint8Array.from([k, 7, 9]),
    time: k * 16.7,
    key: k % 60 === 0,
  }));
  const blob = webm(pictures, { codec: 'V_VP9', width: 640, height: 360, duration: 2171 });
  const top = elements(new Uint8Array(await blob.arrayBuffer()));
  expect(top.map((e) => e.id)).toEqual([0x1a45dfa3, 0x18538067]);
  const parts = elements(top[1]!.content);
  expect(parts.map((e) => e.id)).toEqual([0x1549a966, 0x1654ae6b, 0x1f43b675, 0x1f43b675, 0x1f43b675]);
  const seen: [number, number][] = [];
  for (const cluster of parts.slice(2)) {
    const [start, ...blocks] = elements(cluster.content);
    const from = [...start!.content].reduce((n, b) => 256 * n + b, 0);
    expect(blocks[0]!.content[3]).toBe(0x80);
    for (const b of blocks) seen.push([b.content[4]!, from + 256 * b.content[1]! + b.content[2]!]);
  }
  expect(seen).toEqual(pictures.map((p, k) => [k, Math.round(p.time)]));
});

test('a film plays the run in its own time, and skips frames beyond 60 a second', () => {
  const player = new Player();
  player.setTimes(Array.from({ length: 31 }, (_, f) => f / 30));
  expect(filmPlan(player).map((p) => p.frame)).toEqual(Array.from({ length: 31 }, (_, f) => f));
  expect(filmPlan(player)[30]!.at).toBeCloseTo(1000);
  player.setSpeed(4);
  const quick = filmPlan(player);
  expect(quick.length).toBe(16);
  expect([quick[1]!.frame, quick[15]!.frame]).toEqual([2, 30]);
  expect(quick[15]!.at).toBeCloseTo(250);
  player.setTimes([0, 0]);
  expect(filmPlan(player).map((p) => p.frame)).toEqual([0, 1]);
});
