/** Packs encoded pictures into a WebM film with one track (Matroska's EBML: elements of id, size and content). */

export interface EncodedPicture {
  data: Uint8Array;
  time: number; // [ms] from the start
  key: boolean; // can be shown without those before it
}

export interface FilmFormat {
  codec: 'V_VP8' | 'V_VP9';
  width: number;
  height: number;
  duration: number; // [ms]
}

const kClusterReach = 30_000; // [ms]; a picture's time within its cluster has 16 bits

type Content = Uint8Array | Content[];

const bytesOf = (n: number): Uint8Array => {
  const out: number[] = [];
  do out.unshift(n % 256);
  while ((n = Math.floor(n / 256)) > 0);
  return Uint8Array.from(out);
};
const text = (s: string) => new TextEncoder().encode(s);
const float = (x: number) => {
  const out = new Uint8Array(8);
  new DataView(out.buffer).setFloat64(0, x);
  return out;
};
const length = (c: Content): number =>
  c instanceof Uint8Array ? c.length : c.reduce((sum, part) => sum + length(part), 0);

/** An element; sizes take eight bytes throughout. */
function element(id: number, ...content: Content[]): Content {
  const size = new Uint8Array(8);
  new DataView(size.buffer).setBigUint64(0, BigInt(length(content)));
  size[0] = 1;
  return [bytesOf(id), size, content];
}

function flat(c: Content, out: Uint8Array<ArrayBuffer>[] = []): Uint8Array<ArrayBuffer>[] {
  if (c instanceof Uint8Array) out.push(c as Uint8Array<ArrayBuffer>);
  else for (const part of c) flat(part, out);
  return out;
}

function block(picture: EncodedPicture, start: number): Content {
  const head = new Uint8Array(4);
  head[0] = 0x81; // track 1
  new DataView(head.buffer).setInt16(1, picture.time - start);
  head[3] = picture.key ? 0x80 : 0;
  return element(0xa3, head, picture.data);
}

/** @param pictures in the order of time, the first one a key */
export function webm(pictures: EncodedPicture[], format: FilmFormat): Blob {
  const clusters: { start: number; blocks: Content[] }[] = [];
  for (const picture of pictures) {
    const time = Math.round(picture.time);
    const last = clusters[clusters.length - 1];
    if (!last || picture.key || time - last.start > kClusterReach) clusters.push({ start: time, blocks: [] });
    const cluster = clusters[clusters.length - 1]!;
    cluster.blocks.push(block({ ...picture, time }, cluster.start));
  }
  const file: Content = [
    element(
      0x1a45dfa3,
      element(0x4286, bytesOf(1)),
      element(0x42f7, bytesOf(1)),
      element(0x42f2, bytesOf(4)),
      element(0x42f3, bytesOf(8)),
      element(0x4282, text('webm')),
      element(0x4287, bytesOf(2)),
      element(0x4285, bytesOf(2)),
    ),
    element(
      0x18538067,
      element(
        0x1549a966,
        element(0x2ad7b1, bytesOf(1_000_000)), // times in milliseconds
        element(0x4489, float(format.duration)),
        element(0x4d80, text('brim')),
        element(0x5741, text('brim')),
      ),
      element(
        0x1654ae6b,
        element(
          0xae,
          element(0xd7, bytesOf(1)),
          element(0x73c5, bytesOf(1)),
          element(0x83, bytesOf(1)), // video
          element(0x9c, bytesOf(0)), // no lacing
          element(0x86, text(format.codec)),
          element(0xe0, element(0xb0, bytesOf(format.width)), element(0xba, bytesOf(format.height))),
        ),
      ),
      ...clusters.map((c) => element(0x1f43b675, element(0xe7, bytesOf(c.start)), ...c.blocks)),
    ),
  ];
  return new Blob(flat(file), { type: 'video/webm' });
}
