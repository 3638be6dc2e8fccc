/**
 * The one binary message of the viewer's HTTP interface: a bag of named arrays, little-endian.
 *
 *   offset  type        meaning
 *   0       char[4]     "BRMA"
 *   4       uint32      version, 1
 *   8       uint32      number of arrays, n
 *   12      uint32      total size of the message in bytes, for telling a cut one
 *   16      n entries of 56 bytes:
 *             char[32]  name, padded with zeros
 *             uint32    element type: 1 float32, 2 int32, 3 float64
 *             int32     body the array belongs to, -1 for none
 *             uint32    rows
 *             uint32    columns
 *             uint64    offset of the first element from the start of the message, a multiple of 8
 *
 * The C++ twin is apps/server/array_message.cpp; both are held to test/golden/arrays.bin.
 */

export type Elements = Float32Array<ArrayBuffer> | Int32Array<ArrayBuffer> | Float64Array<ArrayBuffer>;

export interface NamedArray {
  name: string;
  body: number;
  rows: number;
  columns: number;
  data: Elements;
}

const kMagic = 0x414d5242; // "BRMA" read as a little-endian number
const kVersion = 1;
const kHeaderBytes = 16;
const kEntryBytes = 56;
const kNameBytes = 32;

const align8 = (n: number) => (n + 7) & ~7;

function typeCode(data: Elements): number {
  if (data instanceof Float32Array) return 1;
  if (data instanceof Int32Array) return 2;
  return 3;
}

export function array(name: string, data: Elements, columns = 1, body = -1): NamedArray {
  return { name, body, columns, rows: columns > 0 ? data.length / columns : 0, data };
}

export function encodeArrays(arrays: NamedArray[]): ArrayBuffer {
  let end = align8(kHeaderBytes + kEntryBytes * arrays.length);
  const offsets = arrays.map((a) => {
    const at = end;
    end = align8(end + a.data.byteLength);
    return at;
  });
  const buffer = new ArrayBuffer(end);
  const view = new DataView(buffer);
  view.setUint32(0, kMagic, true);
  view.setUint32(4, kVersion, true);
  view.setUint32(8, arrays.length, true);
  view.setUint32(12, end, true);
  arrays.forEach((a, i) => {
    const at = kHeaderBytes + i * kEntryBytes;
    const name = new TextEncoder().encode(a.name);
    if (name.length >= kNameBytes) throw new Error(`array name too long: ${a.name}`);
    if (a.rows * a.columns !== a.data.length) throw new Error(`${a.name}: shape does not match its data`);
    new Uint8Array(buffer, at, kNameBytes).set(name);
    view.setUint32(at + 32, typeCode(a.data), true);
    view.setInt32(at + 36, a.body, true);
    view.setUint32(at + 40, a.rows, true);
    view.setUint32(at + 44, a.columns, true);
    view.setBigUint64(at + 48, BigInt(offsets[i]!), true);
    new Uint8Array(buffer, offsets[i]!, a.data.byteLength).set(
      new Uint8Array(a.data.buffer, a.data.byteOffset, a.data.byteLength),
    );
  });
  return buffer;
}

/** The arrays of a message, as views into it. Throws an Error that says what is wrong with a bad message. */
export function decodeArrays(buffer: ArrayBuffer): NamedArray[] {
  if (buffer.byteLength < kHeaderBytes) throw new Error(`message too short: ${buffer.byteLength} bytes`);
  const view = new DataView(buffer);
  if (view.getUint32(0, true) !== kMagic) throw new Error('not a message of brim: wrong first bytes');
  const version = view.getUint32(4, true);
  if (version !== kVersion) throw new Error(`message version ${version}, this page reads ${kVersion}`);
  const count = view.getUint32(8, true);
  const size = view.getUint32(12, true);
  if (size !== buffer.byteLength) throw new Error(`message cut: ${buffer.byteLength} of ${size} bytes`);
  if (kHeaderBytes + count * kEntryBytes > size) throw new Error('message cut inside its table');
  const arrays: NamedArray[] = [];
  for (let i = 0; i < count; ++i) {
    const at = kHeaderBytes + i * kEntryBytes;
    const bytes = new Uint8Array(buffer, at, kNameBytes);
    const zero = bytes.indexOf(0);
    const name = new TextDecoder().decode(bytes.subarray(0, zero < 0 ? kNameBytes : zero));
    const type = view.getUint32(at + 32, true);
    const body = view.getInt32(at + 36, true);
    const rows = view.getUint32(at + 40, true);
    const columns = view.getUint32(at + 44, true);
    const offset = Number(view.getBigUint64(at + 48, true));
    const length = rows * columns;
    const bytesPer = type === 3 ? 8 : 4;
    if (offset % 8 !== 0 || offset + length * bytesPer > size)
      throw new Error(`array ${name} lies outside the message`);
    let data: Elements;
    if (type === 1) data = new Float32Array(buffer, offset, length);
    else if (type === 2) data = new Int32Array(buffer, offset, length);
    else if (type === 3) data = new Float64Array(buffer, offset, length);
    else throw new Error(`array ${name} has unknown element type ${type}`);
    arrays.push({ name, body, rows, columns, data });
  }
  return arrays;
}

/** The array of that name (and body), or undefined. */
export function find(arrays: NamedArray[], name: string, body = -1): NamedArray | undefined {
  return arrays.find((a) => a.name === name && a.body === body);
}
