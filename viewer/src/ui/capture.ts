/** Pictures and films of the run, saved by the browser. */
import type { Player } from '../player';
import { webm, type EncodedPicture } from './webm';
import { zip } from './zip';

export function download(blob: Blob, name: string): void {
  const link = document.createElement('a');
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
}

export const pngOf = (canvas: HTMLCanvasElement): Promise<Blob> =>
  new Promise((done, fail) =>
    canvas.toBlob((b) => (b ? done(b) : fail(new Error('the picture could not be made'))), 'image/png'),
  );

export const padded = (frame: number) => String(frame).padStart(5, '0');

/** Every frame as a picture, in one zip. `show` draws a frame exactly; `report` returns false to stop. */
export async function pictureSequence(
  canvas: HTMLCanvasElement,
  frames: number,
  show: (frame: number) => Promise<void>,
  report: (done: number) => boolean,
): Promise<Blob | undefined> {
  const files: { name: string; data: Uint8Array<ArrayBuffer> }[] = [];
  for (let f = 0; f < frames; ++f) {
    await show(f);
    const data = new Uint8Array(await (await pngOf(canvas)).arrayBuffer());
    files.push({ name: `frame_${padded(f)}.png`, data });
    if (!report(f + 1)) return undefined;
  }
  return zip(files);
}

/** Moments of a film of a run: for each picture its time in the film [ms] and the run's frame. */
export function filmPlan(player: Player): { at: number; frame: number }[] {
  const first = player.time(0);
  const seconds = (player.time(player.frames - 1) - first) / player.speed;
  const rate = seconds > 0 ? Math.min(60, (player.frames - 1) / seconds) : 30;
  const count = seconds > 0 ? Math.round(seconds * rate) + 1 : player.frames;
  return Array.from({ length: count }, (_, k) => ({
    at: (1000 * k) / rate,
    frame: seconds > 0 ? player.frameAt(first + ((k + 1e-3) / rate) * player.speed) : k,
  }));
}

async function encoderFor(width: number, height: number) {
  if (typeof VideoEncoder === 'undefined')
    throw new Error(
      'This browser cannot make films here: it needs WebCodecs, which browsers give to localhost and https. Save the pictures instead.',
    );
  for (const [codec, name] of [
    ['vp09.00.51.08', 'V_VP9'],
    ['vp8', 'V_VP8'],
  ] as const) {
    const config = { codec, width, height, bitrate: 12 * width * height, framerate: 60 };
    if ((await VideoEncoder.isConfigSupported(config)).supported) return { config, name };
  }
  throw new Error('This browser has no encoder for films; save the pictures instead.');
}

/**
 * The run once through as a film, in the run's own time times the player's speed, up to 60 pictures a second. Every picture
 * is drawn and encoded in turn, so that a slow machine makes the same film. `report` returns false to end it early.
 */
export async function film(
  canvas: HTMLCanvasElement,
  player: Player,
  show: (frame: number) => Promise<void>,
  report: (done: number, all: number) => boolean,
): Promise<Blob> {
  const [width, height] = [canvas.width & ~1, canvas.height & ~1]; // coded in blocks of two pixels
  const { config, name } = await encoderFor(width, height);
  const pictures: EncodedPicture[] = [];
  let failure: Error | undefined;
  const encoder = new VideoEncoder({
    output: (chunk) => {
      const data = new Uint8Array(chunk.byteLength);
      chunk.copyTo(data);
      pictures.push({ data, time: chunk.timestamp / 1000, key: chunk.type === 'key' });
    },
    error: (error) => (failure = error),
  });
  encoder.configure(config);
  const plan = filmPlan(player);
  const each = plan[1]?.at ?? 1000 / 30;
  for (const [k, { at, frame }] of plan.entries()) {
    await show(frame);
    const picture = new VideoFrame(canvas, {
      timestamp: Math.round(1000 * at),
      duration: Math.round(1000 * each),
      visibleRect: { x: 0, y: 0, width, height },
    });
    encoder.encode(picture, { keyFrame: k % 60 === 0 });
    picture.close();
    while (encoder.encodeQueueSize > 4 && !failure) await new Promise((done) => setTimeout(done, 5));
    if (failure) throw failure;
    if (!report(k + 1, plan.length)) break;
  }
  await encoder.flush();
  encoder.close();
  const end = (pictures[pictures.length - 1]?.time ?? 0) + each;
  return webm(pictures, { codec: name, width, height, duration: end });
}
