/** The bar above the picture: what is shown, and its buttons. */
import type { App } from '../app';
import { h, iconButton } from './dom';

export function headerBar(app: App): HTMLElement {
  const record = iconButton('film', 'film the run (WebM)', () => void app.captures.toggleFilm(), {
    class: 'icon record',
  });
  return h(
    'header',
    { class: 'bar' },
    iconButton('panel', 'bodies and contacts (b)', () => app.togglePanel()),
    h('b', { class: 'logo' }, 'brim'),
    h('span', { class: 'title' }),
    h('span', { class: 'spacer' }),
    iconButton('fit', 'fit the view (f)', () => app.fit()),
    iconButton('camera', 'save a picture (s)', () => void app.captures.savePicture()),
    record,
    h(
      'button',
      {
        class: 'text',
        type: 'button',
        title: 'save every frame as a picture',
        onclick: () => void app.captures.saveSequence(),
      },
      'PNGs',
    ),
    iconButton('help', 'keys (?)', () => app.toggleHelp()),
    iconButton('chart', 'plots (p)', () => app.togglePlots()),
  );
}
