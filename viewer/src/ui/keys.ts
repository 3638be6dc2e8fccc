/** The keyboard. */
import type { App } from '../app';

export function bindKeys(app: App): void {
  const actions: Record<string, (shift: boolean) => void> = {
    ' ': () => app.player.toggle(),
    ArrowLeft: (shift) => app.player.step(shift ? -10 : -1),
    ArrowRight: (shift) => app.player.step(shift ? 10 : 1),
    Home: () => app.player.step(-app.player.frames),
    End: () => app.player.step(app.player.frames),
    f: () => app.fit(),
    1: () => app.setPose({ azimuth: -90, elevation: 4 }),
    2: () => app.setPose({ azimuth: 0, elevation: 4 }),
    3: () => app.setPose({ azimuth: -90, elevation: 89 }),
    w: () => app.panel.toggleWireframe(),
    c: () => app.panel.cycleContacts(),
    t: () => app.panel.setTiles(!app.panel.tilesShown),
    a: () => app.panel.setLinks(!app.panel.linksShown),
    d: () => app.panel.slice.setOn(!app.panel.slice.on),
    m: () => app.panel.stress.setOn(!app.panel.stress.on),
    x: () => app.panel.slice.setAxis(0),
    y: () => app.panel.slice.setAxis(1),
    z: () => app.panel.slice.setAxis(2),
    l: () => app.player.setLoop(!app.player.loop),
    p: () => app.togglePlots(),
    b: () => app.togglePanel(),
    s: () => void app.captures.savePicture(),
    '?': () => app.toggleHelp(),
  };
  window.addEventListener('keydown', (e) => {
    if (e.ctrlKey || e.metaKey || e.altKey) return;
    const target = e.target as HTMLElement;
    const typing = target instanceof HTMLSelectElement;
    // A focused slider or button keeps the keys that work it; the time line's slider is the time line.
    const kind =
      target instanceof HTMLInputElement ? target.type : target instanceof HTMLButtonElement ? 'button' : '';
    const own =
      kind === 'range'
        ? !target.classList.contains('scrub') && e.key.length > 1
        : kind !== '' && e.key === ' ';
    const action = actions[e.key.length === 1 ? e.key.toLowerCase() : e.key];
    if (!action || typing || own) return;
    if (document.querySelector('dialog[open]') && e.key !== '?') return;
    e.preventDefault();
    action(e.shiftKey);
  });
}
