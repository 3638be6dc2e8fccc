/** A sparse grid of numbers: blocks of 8³ nodes where something is, found through a table over the whole box. */

export const kSide = 8; // nodes along a block
const kNodes = kSide ** 3;

export class BlockGrid {
  private readonly table: Int32Array; // block -> its number + 1, 0 where there is none
  readonly blocks: number[] = []; // place in the table of each block there is
  values = new Float32Array(64 * kNodes);

  /** @param size blocks along x, y and z */
  constructor(readonly size: readonly [number, number, number]) {
    this.table = new Int32Array(size[0] * size[1] * size[2]);
  }

  /** Number of the block at a place, or -1. */
  find(i: number, j: number, k: number): number {
    const [nx, ny, nz] = this.size;
    if (i < 0 || j < 0 || k < 0 || i >= nx || j >= ny || k >= nz) return -1;
    return this.table[i + nx * (j + ny * k)]! - 1;
  }

  /** Number of the block at a place, which is made of zeros if it was not there. */
  touch(i: number, j: number, k: number): number {
    const place = i + this.size[0] * (j + this.size[1] * k);
    const known = this.table[place]!;
    if (known) return known - 1;
    const number = this.blocks.length;
    this.blocks.push(place);
    this.table[place] = number + 1;
    if (this.blocks.length * kNodes > this.values.length) {
      const larger = new Float32Array(2 * this.values.length);
      larger.set(this.values);
      this.values = larger;
    }
    return number;
  }

  /** Where a block lies, in blocks. */
  placeOf(block: number): [number, number, number] {
    const [nx, ny] = this.size;
    const place = this.blocks[block]!;
    return [place % nx, Math.floor(place / nx) % ny, Math.floor(place / (nx * ny))];
  }

  /** Place of a node's value in `values`, or -1 where there is no block. */
  at(i: number, j: number, k: number): number {
    const block = this.find(i >> 3, j >> 3, k >> 3);
    return block < 0 ? -1 : block * kNodes + (i & 7) + kSide * ((j & 7) + kSide * (k & 7));
  }

  clear(): void {
    this.values.fill(0, 0, this.blocks.length * kNodes);
  }
}
