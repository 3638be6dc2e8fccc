/** Small helpers for building the page. */

type Child = Node | string | undefined;
type Props = Record<string, unknown>;

/** An element: `class`, `aria-*` and `data-*` become attributes, functions `onX` listeners, the rest properties. */
export function h<K extends keyof HTMLElementTagNameMap>(
  tag: K,
  props: Props = {},
  ...children: Child[]
): HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  for (const [key, value] of Object.entries(props)) {
    if (value === undefined) continue;
    if (key.startsWith('on')) element.addEventListener(key.slice(2), value as EventListener);
    else if (key === 'class' || key === 'for' || key === 'role' || key.includes('-'))
      element.setAttribute(key, String(value));
    else (element as unknown as Props)[key] = value;
  }
  element.append(...children.filter((c): c is Node | string => c !== undefined));
  return element;
}

const paths: Record<string, string> = {
  play: 'M7 4.5v15l12-7.5z',
  pause: 'M6.5 4.5h4v15h-4zM13.5 4.5h4v15h-4z',
  first: 'M5 5h2.4v14H5zM19 5v14l-10-7z',
  last: 'M16.6 5H19v14h-2.4zM5 5v14l10-7z',
  back: 'M17 5v14L7.5 12z',
  forward: 'M7 5v14l9.500-7z',
  loop: 'M17 17H8.500a4.500 4.500 0 0 1 0-9H15V5l5 4-5 4v-3H8.500a2.500 2.500 0 0 0 0 5H17z',
  eye: 'M12 5.500c-5 0-8.600 4-9.800 6.500 1.200 2.500 4.800 6.500 9.800 6.500s8.600-4 9.800-6.500c-1.200-2.500-4.800-6.500-9.800-6.500zm0 11a4.500 4.500 0 1 1 0-9 4.500 4.500 0 0 1 0 9zm0-2.200a2.300 2.300 0 1 0 0-4.600 2.300 2.300 0 0 0 0 4.600z',
  hidden:
    'M3.500 4.900 5 3.400l15.600 15.700-1.400 1.400-3-3c-1.300.6-2.700 1-4.200 1-5 0-8.600-4-9.800-6.500.6-1.300 1.900-3 3.700-4.400zM12 5.500c5 0 8.600 4 9.800 6.500-.5 1-1.400 2.200-2.600 3.300l-2.900-2.900.2-.9A4.500 4.500 0 0 0 12 7.500l-1 .1-1.900-1.900c.9-.1 1.900-.2 2.900-.2z',
  wire: 'M3 5.200 12 2l9 3.200v13.600L12 22l-9-3.200zm2 2.700v9.400l6 2.200v-9.400zm14 0-6 2.200v9.400l6-2.200zM12 4.100 6.600 6l5.400 2 5.400-2z',
  drop: 'M12 2.5c3.6 4.4 6.2 7.7 6.2 11.2a6.2 6.2 0 0 1-12.4 0C5.8 10.2 8.4 6.9 12 2.5zm0 3.3c-2.5 3.2-4.2 5.6-4.2 7.9a4.2 4.2 0 0 0 8.4 0c0-2.3-1.7-4.7-4.2-7.9z',
  camera:
    'M9 4.500 7.500 7H4a1.500 1.500 0 0 0-1.500 1.500v9.500A1.500 1.500 0 0 0 4 19.500h16a1.500 1.500 0 0 0 1.500-1.500V8.500A1.500 1.500 0 0 0 20 7h-3.500L15 4.500zm3 4.500a4.200 4.200 0 1 1 0 8.400A4.200 4.200 0 0 1 12 9zm0 2a2.200 2.200 0 1 0 0 4.400 2.200 2.200 0 0 0 0-4.400z',
  film: 'M3 5h18v14H3zm2 2v2h2V7zm0 4v2h2v-2zm0 4v2h2v-2zm4-8v10h6V7zm8 0v2h2V7zm0 4v2h2v-2zm0 4v2h2v-2z',
  fit: 'M4 4h6v2H6v4H4zm10 0h6v6h-2V6h-4zM4 14h2v4h4v2H4zm14 0h2v6h-6v-2h4zM9 9h6v6H9z',
  help: 'M12 2.500a9.500 9.500 0 1 0 0 19 9.500 9.500 0 0 0 0-19zm0 17a7.500 7.500 0 1 1 0-15 7.500 7.500 0 0 1 0 15zm-1-3.700h2v2h-2zm1-9.600a3.400 3.400 0 0 0-3.400 3.300h1.900a1.500 1.500 0 1 1 2.600 1c-.9.900-2 1.500-2 3.400h1.900c0-1.500 2.400-1.900 2.400-4.300A3.400 3.400 0 0 0 12 6.200z',
  panel: 'M3 4.500h18v15H3zm2 2v11h3.500v-11zm5.500 0v11H19v-11z',
  chart: 'M4 4h2v14h14v2H4zm4 8h2.500v5H8zm4.200-5h2.500v10h-2.500zm4.300 3H19v7h-2.500z',
};

export function icon(name: string): SVGSVGElement {
  const svg = document.createElementNS('http://www.w3.org/2000/svg', 'svg');
  svg.setAttribute('viewBox', '0 0 24 24');
  svg.setAttribute('aria-hidden', 'true');
  const path = document.createElementNS('http://www.w3.org/2000/svg', 'path');
  path.setAttribute('d', paths[name] ?? '');
  path.setAttribute('fill-rule', 'evenodd');
  svg.append(path);
  return svg;
}

export function iconButton(
  name: string,
  label: string,
  onclick: () => void,
  extra: Props = {},
): HTMLButtonElement {
  return h(
    'button',
    { class: 'icon', title: label, 'aria-label': label, type: 'button', onclick, ...extra },
    icon(name),
  );
}

export function setIcon(button: HTMLButtonElement, name: string, label: string): void {
  if (button.dataset.icon === name) return;
  button.dataset.icon = name;
  button.replaceChildren(icon(name));
  button.title = label;
  button.setAttribute('aria-label', label);
}

/** A number for people: three significant digits, with an SI prefix where a unit is given. */
export function human(value: number, unit = ''): string {
  if (!Number.isFinite(value)) return Number.isNaN(value) ? 'not a number' : value > 0 ? '∞' : '−∞';
  if (value === 0) return unit ? `0 ${unit}` : '0';
  const size = Math.abs(value);
  if (unit) {
    const prefixes: [number, string][] = [
      [1e9, 'G'],
      [1e6, 'M'],
      [1e3, 'k'],
      [1, ''],
      [1e-3, 'm'],
      [1e-6, 'µ'],
      [1e-9, 'n'],
    ];
    const [factor, prefix] = prefixes.find(([f]) => size >= f * 0.9995) ?? [1e-9, 'n'];
    return `${digits(value / factor)} ${prefix}${unit}`;
  }
  if (size >= 1e5 || size < 1e-3) return value.toExponential(1).replace('e+', 'e').replace('-', '−');
  return digits(value);
}

function digits(x: number): string {
  const text = Math.abs(x) >= 1000 ? Math.round(x).toString() : x.toPrecision(3);
  return (text.includes('.') ? text.replace(/\.?0+$/, '') : text).replace('-', '−');
}
