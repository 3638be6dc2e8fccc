/** Pictures and films of the run, saved by the browser. */
import type { Player } from '../player';
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

/** Films the picture while the run plays once from its start, in real time. */
export function film(canvas: HTMLCanvasElement, player: Player): { done: Promise<Blob>; stop(): void } {
  const type = ['video/webm;codecs=vp9', 'video/webm;codecs=vp8', 'video/webm'].find((t) =>
    MediaRecorder.isTypeSupported(t),
  );
  if (!type) throw new Error('this browser cannot record films; save the pictures instead');
  const recorder = new MediaRecorder(canvas.captureStream(60), {
    mimeType: type,
    videoBitsPerSecond: 24_000_000,
  });
  const pieces: Blob[] = [];
  recorder.ondataavailable = (e) => pieces.push(e.data);
  const { loop } = player;
  const stop = () => {
    if (recorder.state !== 'inactive') recorder.stop();
  };
  const done = new Promise<Blob>((resolve) => {
    recorder.onstop = () => {
      forget();
      player.setLoop(loop);
      resolve(new Blob(pieces, { type: 'video/webm' }));
    };
  });
  player.step(-player.frames);
  player.setLoop(false);
  recorder.start();
  player.toggle();
  const forget = player.onChange(() => {
    if (!player.playing) setTimeout(stop, 150); // so that the last frame is in
  });
  return { done, stop };
}
