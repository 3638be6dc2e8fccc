/** Packs files into a zip without compression: pictures are compressed already. Up to 4 GiB and 65535 files. */

const crcTable = Uint32Array.from({ length: 256 }, (_, n) => {
  let c = n;
  for (let k = 0; k < 8; ++k) c = c & 1 ? 0xedb88320 ^ (c >>> 1) : c >>> 1;
  return c;
});

export function crc32(bytes: Uint8Array): number {
  let c = 0xffffffff;
  for (const b of bytes) c = crcTable[(c ^ b) & 0xff]! ^ (c >>> 8);
  return (c ^ 0xffffffff) >>> 0;
}

/** One header, local or central; the central one repeats the local one's fields and adds its place. */
function header(name: Uint8Array, data: Uint8Array, crc: number, offset?: number): Uint8Array<ArrayBuffer> {
  const central = offset !== undefined;
  const size = central ? 46 : 30;
  const out = new Uint8Array(size + name.length);
  const view = new DataView(out.buffer);
  view.setUint32(0, central ? 0x02014b50 : 0x04034b50, true);
  const at = central ? 6 : 4;
  if (central) view.setUint16(4, 20, true); // made by, version 2.0
  view.setUint16(at, 20, true);
  view.setUint16(at + 8, 0x21, true); // date: 1980-01-01
  view.setUint16(at + 6, 0, true);
  view.setUint32(at + 10, crc, true);
  view.setUint32(at + 14, data.length, true);
  view.setUint32(at + 18, data.length, true);
  view.setUint16(at + 22, name.length, true);
  if (central) view.setUint32(42, offset, true);
  out.set(name, size);
  return out;
}

export function zip(files: { name: string; data: Uint8Array<ArrayBuffer> }[]): Blob {
  const parts: Uint8Array<ArrayBuffer>[] = [];
  const directory: Uint8Array<ArrayBuffer>[] = [];
  let offset = 0;
  for (const { name, data } of files) {
    const bytes = new TextEncoder().encode(name);
    const crc = crc32(data);
    const local = header(bytes, data, crc);
    directory.push(header(bytes, data, crc, offset));
    parts.push(local, data);
    offset += local.length + data.length;
  }
  const directorySize = directory.reduce((sum, d) => sum + d.length, 0);
  const end = new Uint8Array(22);
  const view = new DataView(end.buffer);
  view.setUint32(0, 0x06054b50, true);
  view.setUint16(8, files.length, true);
  view.setUint16(10, files.length, true);
  view.setUint32(12, directorySize, true);
  view.setUint32(16, offset, true);
  return new Blob([...parts, ...directory, end], { type: 'application/zip' });
}
