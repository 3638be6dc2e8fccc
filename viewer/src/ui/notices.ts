/** Lines above the picture, each under a name: what is being waited for, and what went wrong. */
import { h } from './dom';

export class Notices {
  readonly element = h('div', { class: 'banner', hidden: true, role: 'status' });
  private readonly lines = new Map<string, string>();

  has(name: string): boolean {
    return this.lines.has(name);
  }

  /** Shows a line under a name; no text takes it away. */
  set(name: string, text?: string): void {
    if (this.lines.get(name) === text) return;
    if (text) this.lines.set(name, text);
    else this.lines.delete(name);
    this.element.hidden = this.lines.size === 0;
    this.element.replaceChildren(
      ...[...this.lines].map(([key, line]) => h('p', { 'data-notice': key }, line)),
    );
  }
}
