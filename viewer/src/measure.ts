/** What a frame costs the page: its scripts' time to decode, to bring into the picture and to draw. */
import type { App } from './app';
import { decodeFrame } from './client';

export interface FrameCost {
  bytes: number;
  decode: number; // [ms] from bytes to arrays
  show: number; // [ms] into vertex buffers, tables and instances
  draw: number; // [ms] of scripts that issue the drawing; the graphics card's own time is not in it
  calls: number; // draw calls, shadows with them
  triangles: number;
}

/** Goes through some frames as playing would, each loaded beforehand. */
export async function measure(app: App, frames: number[]): Promise<FrameCost[]> {
  const costs: FrameCost[] = [];
  for (const frame of frames) {
    const answer = await fetch(`api/frame/${frame}`);
    const bytes = await answer.arrayBuffer();
    const start = performance.now();
    const decoded = decodeFrame(frame, bytes);
    const there = performance.now();
    app.showNow(decoded);
    const shown = performance.now();
    app.picture.stage.draw(true);
    const drawn = performance.now();
    const { calls, triangles } = app.picture.stage.renderer.info.render;
    costs.push({
      bytes: bytes.byteLength,
      decode: there - start,
      show: shown - there,
      draw: drawn - shown,
      calls,
      triangles,
    });
    await new Promise((done) => setTimeout(done)); // the page breathes, as between two frames
  }
  return costs;
}
