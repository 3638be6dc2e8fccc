/** What the plots draw, as plain data: which series, in what unit, and how many frames share a pixel. */
import type { SensorInfo, Series } from '../run';
import { phaseColours } from '../scene/palette';

export interface Curve {
  name: string;
  colour: string;
  values: Float64Array;
}

export interface PlotSpec {
  title: string;
  unit: string;
  kind: 'stack' | 'lines' | 'log';
  curves: Curve[];
}

const words = (name: string) => name.replaceAll('_', ' ');

/** Seconds of each phase, which add up to those of the frame: contact's part of the solve is a curve of its own. */
function phaseCurves(series: Series): Curve[] {
  const contact = series.get('seconds_solve_contact');
  return Object.entries(phaseColours).flatMap(([phase, colour]) => {
    const whole = series.get(`seconds_${phase}`);
    if (!whole) return [];
    const shared = phase === 'solve' && contact;
    const values = shared ? whole.map((s, f) => Math.max(0, s - (contact[f] ?? 0))) : whole;
    return [{ name: words(phase), colour, values }];
  });
}

/** The plots a run has data for. */
export function plotSpecs(series: Series, sensors: SensorInfo[] = []): PlotSpec[] {
  const pick = (names: [string, string, string][]): Curve[] =>
    names.flatMap(([key, name, colour]) => {
      const values = series.get(key);
      return values ? [{ name, colour, values }] : [];
    });
  const specs: PlotSpec[] = [
    { title: 'Time per frame', unit: 's', kind: 'stack', curves: phaseCurves(series) },
    {
      title: 'Energy',
      unit: 'J',
      kind: 'lines',
      curves: pick([
        ['kinetic_energy', 'kinetic', '#4f83b5'],
        ['potential_energy', 'potential', '#3f9c84'],
        ['contact_energy', 'contact', '#cf6f4a'],
      ]),
    },
    { title: 'Contacts', unit: '', kind: 'lines', curves: pick([['contacts', 'nodes', '#b3556b']]) },
    {
      title: 'Worst overlap',
      unit: 'voxels',
      kind: 'lines',
      curves: pick([['worst_overlap', 'overlap', '#6b4f8f']]),
    },
    {
      title: 'Iterations of the solver',
      unit: '',
      kind: 'lines',
      curves: pick([['cg_iterations', 'CG', '#7b5a3a']]),
    },
    {
      title: 'Momentum error',
      unit: '',
      kind: 'log',
      curves: pick([
        ['momentum_error', 'linear', '#4f83b5'],
        ['angular_error', 'angular', '#cf6f4a'],
      ]),
    },
  ];
  return [...sensorSpecs(series, sensors), ...specs.filter((s) => s.curves.length > 0)];
}

/** What is drawn of each kind of sensor: all that begins so. */
const drawnOfKind: Record<string, string[]> = {
  force: ['force', 'torque'],
  contact: ['touching', 'impulse'],
  pressure: ['force', 'pressure'],
  motion: ['position', 'velocity'],
  strain: ['strain'],
  distance: ['distance'],
  level: ['level'],
  link: ['force'],
};

const curveColours = ['#b3556b', '#3f9c84', '#4f83b5', '#cf6f4a', '#6b4f8f', '#7b5a3a'];

/** Plots of the run's sensors: readings of one unit that belong together share a plot. */
function sensorSpecs(series: Series, sensors: SensorInfo[]): PlotSpec[] {
  const specs: PlotSpec[] = [];
  sensors.forEach((sensor, number) => {
    for (const stem of drawnOfKind[sensor.kind] ?? []) {
      const curves: Curve[] = [];
      let unit = '';
      sensor.channels.forEach((channel, c) => {
        const values = series.get(`sensor ${number} ${c}`);
        if (!values || !(channel === stem || channel.startsWith(`${stem}_`))) return;
        unit = sensor.units[c] ?? '';
        const name = words(channel === stem ? stem : channel.slice(stem.length + 1));
        curves.push({ name, colour: curveColours[curves.length % curveColours.length]!, values });
      });
      if (curves.length) specs.push({ title: `${sensor.name}: ${words(stem)}`, unit, kind: 'lines', curves });
    }
  });
  return specs;
}

/**
 * Squeezes values into bins: the largest of each bin, so that no peak is lost, or their mean for stacked shares.
 * Bin b covers frames floor(b n / bins) to floor((b+1) n / bins), and never fewer than one.
 */
export function squeeze(values: ArrayLike<number>, bins: number, how: 'max' | 'mean'): Float64Array {
  const n = values.length;
  const count = Math.min(bins, n);
  const out = new Float64Array(count);
  for (let b = 0; b < count; ++b) {
    const from = Math.floor((b * n) / count);
    const to = Math.max(from + 1, Math.floor(((b + 1) * n) / count));
    let sum = 0;
    let most = -Infinity;
    for (let i = from; i < to; ++i) {
      sum += values[i]!;
      if (values[i]! > most) most = values[i]!;
    }
    out[b] = how === 'max' ? (most === -Infinity ? NaN : most) : sum / (to - from);
  }
  return out;
}

/** A round number at or above x: 1, 2, 2.5 or 5 times a power of ten. */
export function roundUp(x: number): number {
  if (!(x > 0) || !Number.isFinite(x)) return 1;
  const power = 10 ** Math.floor(Math.log10(x));
  const m = x / power;
  return power * ([1, 2, 2.5, 5, 10].find((r) => m <= r * (1 + 1e-9)) ?? 10);
}

/** Joins what came before with what has just been fetched. */
export function appendSeries(old: Series, more: Series): Series {
  const joined: Series = new Map();
  for (const [name, values] of more) {
    const before = old.get(name) ?? new Float64Array(0);
    const all = new Float64Array(before.length + values.length);
    all.set(before);
    all.set(values, before.length);
    joined.set(name, all);
  }
  return joined.size ? joined : old;
}
