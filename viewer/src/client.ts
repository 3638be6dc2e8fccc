/** Talks to the server: everything the page knows of a run comes through here. */
import { decodeArrays } from './codec';
import {
  frameFromArrays,
  seriesFromArrays,
  topologyFromArrays,
  type Frame,
  type RunInfo,
  type Series,
  type Topology,
} from './run';
import { sliceFromArrays, type Slice, type SliceWish } from './slice';
import { stressFromArrays, type Stress } from './stress';

export interface Progress {
  frames: number;
  complete: boolean;
  stopped?: boolean; // complete only because the writer is gone
}

/** The server answered, with an error that says what it could not do. */
export class ServerError extends Error {
  constructor(
    readonly status: number,
    message: string,
  ) {
    super(message);
  }
}

async function request(path: string, method: 'GET' | 'POST' = 'GET'): Promise<Response> {
  const response = await fetch(path, { method });
  if (response.ok) return response;
  let message = `${response.status} ${response.statusText}`;
  try {
    message = ((await response.json()) as { error?: string }).error ?? message;
  } catch {
    // The status says enough.
  }
  throw new ServerError(response.status, message);
}

const arrays = async (path: string) => decodeArrays(await (await request(path)).arrayBuffer());

export const fetchRun = async (): Promise<RunInfo> => (await (await request('api/run')).json()) as RunInfo;

export const fetchTopology = async (body: number): Promise<Topology> =>
  topologyFromArrays(await arrays(`api/topology/${body}`));

export const decodeFrame = (index: number, message: ArrayBuffer): Frame =>
  frameFromArrays(index, decodeArrays(message), message.byteLength);

export const fetchFrame = async (index: number): Promise<Frame> =>
  decodeFrame(index, await (await request(`api/frame/${index}`)).arrayBuffer());

export const fetchSeries = async (from: number): Promise<Series> =>
  seriesFromArrays(await arrays(`api/series?from=${from}`));

export const fetchSlice = async (frame: number, wish: SliceWish): Promise<Slice> =>
  sliceFromArrays(await arrays(`api/slice/${frame}?axis=${wish.axis}&at=${wish.at}&body=${wish.body}`));

export const fetchStress = async (frame: number): Promise<Stress> =>
  stressFromArrays(await arrays(`api/stress/${frame}`));

/** What a person does to the bodies of a run that is being made; places in metres. */
export type HandWish =
  | { what: 'grab'; body: number; vertex: number; x: number; y: number; z: number } // x, y, z from the vertex
  | { what: 'pull'; x: number; y: number; z: number }
  | { what: 'release' };

/** Comes true once the run has been told; it acts before its next step. */
export async function askHand({ what, ...numbers }: HandWish): Promise<void> {
  const query = Object.entries(numbers).map(([key, value]) => `${key}=${value}`);
  await request(`api/${what}${query.length ? `?${query.join('&')}` : ''}`, 'POST');
}

/**
 * Listens to the run's progress. A lost server is reported once and asked for again until it answers; the browser's
 * own retry is not relied on, since it gives up for good on some refusals.
 */
export function watchProgress(on: { progress(p: Progress): void; lost(): void; found(): void }): () => void {
  let source: EventSource | undefined;
  let timer: ReturnType<typeof setTimeout> | undefined;
  let lost = false;
  let stopped = false;
  const open = () => {
    source = new EventSource('api/events');
    source.addEventListener('frames', (event) => {
      if (lost) on.found();
      lost = false;
      on.progress(JSON.parse((event as MessageEvent<string>).data) as Progress);
    });
    source.onerror = () => {
      source?.close();
      if (stopped) return;
      if (!lost) on.lost();
      lost = true;
      timer = setTimeout(open, 1000);
    };
  };
  open();
  return () => {
    stopped = true;
    source?.close();
    clearTimeout(timer);
  };
}
