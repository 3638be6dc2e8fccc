import { mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { expect, test } from 'vitest';
import { array, decodeArrays, encodeArrays, find } from '../src/codec';

/** The message that tests/server/array_message_test.cpp writes with the C++ twin, byte for byte. */
const golden = () =>
  encodeArrays([
    array('time', new Float64Array([0.125])),
    array('positions', new Float32Array([1, 2, 3, -4, 0.5, 6]), 3, 2),
    array('contacts/pair', new Int32Array([0, 1, -7, 2147483647]), 2),
    array('nothing', new Float32Array(0), 3),
  ]);

const path = new URL('./golden/arrays.bin', import.meta.url);

test('a message is the golden file, byte for byte', () => {
  if (process.env.BRIM_WRITE_GOLDEN) {
    mkdirSync(new URL('.', path), { recursive: true });
    writeFileSync(path, Buffer.from(golden()));
  }
  expect(Buffer.from(golden()).equals(readFileSync(path))).toBe(true);
});

test('header and table of a message lie where the description says', () => {
  const bytes = Buffer.from(golden());
  expect(bytes.toString('latin1', 0, 4)).toBe('BRMA');
  expect([bytes.readUInt32LE(4), bytes.readUInt32LE(8), bytes.readUInt32LE(12)]).toEqual([
    1,
    4,
    bytes.length,
  ]);
  const entry = 16 + 56; // of 'positions'
  expect(bytes.toString('latin1', entry, entry + 10)).toBe('positions\0');
  expect([32, 40, 44].map((at) => bytes.readUInt32LE(entry + at))).toEqual([1, 2, 3]);
  expect(bytes.readInt32LE(entry + 36)).toBe(2);
  expect(bytes.readFloatLE(Number(bytes.readBigUInt64LE(entry + 48)) + 12)).toBe(-4);
});

test('random arrays come back as they went', () => {
  const seed = Date.now() % 100000;
  let state = seed;
  const random = () => (state = (state * 48271 + 11) % 2147483647) / 2147483647;
  console.log(`seed ${seed}`);
  for (let round = 0; round < 50; ++round) {
    const arrays = Array.from({ length: Math.floor(random() * 8) }, (_, i) => {
      const columns = 1 + Math.floor(random() * 4);
      const n = columns * Math.floor(random() * 20);
      const kind = Math.floor(random() * 3);
      const values = Array.from({ length: n }, () => Math.round((random() - 0.5) * 1e6));
      const data =
        kind === 0
          ? new Float32Array(values)
          : kind === 1
            ? new Int32Array(values)
            : new Float64Array(values);
      return array(`name ${i}`, data, columns, i - 1);
    });
    expect(decodeArrays(encodeArrays(arrays))).toEqual(arrays);
  }
});

test('a message cut anywhere is refused in words', () => {
  const whole = golden();
  for (let size = 0; size < whole.byteLength; ++size)
    expect(() => decodeArrays(whole.slice(0, size))).toThrow(/short|cut/);
});

test('foreign, newer and inconsistent messages are refused', () => {
  const change = (edit: (view: DataView) => void) => {
    const copy = golden().slice(0);
    edit(new DataView(copy));
    return () => decodeArrays(copy);
  };
  expect(change((v) => v.setUint8(0, 0))).toThrow(/not a message/);
  expect(change((v) => v.setUint32(4, 2, true))).toThrow(/version 2/);
  expect(change((v) => v.setUint32(16 + 40, 1e9, true))).toThrow(/outside/);
  expect(change((v) => v.setUint32(16 + 32, 9, true))).toThrow(/type 9/);
  expect(change((v) => v.setUint32(8, 1e6, true))).toThrow(/table/);
});

test('arrays are found by name and body', () => {
  const arrays = decodeArrays(golden());
  expect(find(arrays, 'positions', 2)?.rows).toBe(2);
  expect(find(arrays, 'positions')).toBeUndefined();
});
