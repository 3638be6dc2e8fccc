import { App } from './app';
import { measure } from './measure';
import './style.css';

/** `?bare` leaves only the picture, drawn when told to: pages made into pictures by `brim render`. */
const app = new App(new URLSearchParams(location.search).has('bare'));

/** How `brim render` and the browser tests reach the page. */
const hook = { app, ready: app.start(), measure: (frames: number[]) => measure(app, frames) };
declare global {
  interface Window {
    brim: typeof hook;
  }
}
window.brim = hook;
