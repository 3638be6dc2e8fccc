import { readFile } from 'node:fs/promises';
import { afterAll, beforeAll, describe, expect, test } from 'vitest';
import type { Browser } from 'playwright-core';
import { fakeRun } from '../dev/fake_run';
import { startFakeServer } from '../dev/fake_server';
import type {} from '../src/main';
import { chromiumPath, close, launch, open, page as folder, type Opened } from './harness';

const frameOf = (o: Opened) => o.page.evaluate(() => window.brim.app.player.frame);
const shownOf = (o: Opened) => o.page.evaluate(() => window.brim.app.picture.shown?.index);
const notice = (o: Opened, name: string) => o.page.locator(`[data-notice="${name}"]`);
const until = (o: Opened, what: () => boolean) =>
  o.page.waitForFunction(what, undefined, { timeout: 100_000 });

describe.skipIf(!chromiumPath)('the page', () => {
  let browser: Browser;
  beforeAll(async () => {
    browser = await launch();
  });
  afterAll(() => browser?.close());

  test('shows a run, asks nobody but its server, and throws nothing', async () => {
    const o = await open(browser);
    await o.page.waitForFunction(() => window.brim.app.picture.shown?.index === 0);
    expect(await o.page.locator('.bodies li').count()).toBe(7);
    expect(await o.page.locator('.plotcard').count()).toBe(6);
    expect(await o.page.locator('.mark').count()).toBe(2);
    // The picture is neither empty nor of one colour: the middle differs from the corner.
    const colours = await o.page.evaluate(async () => {
      await window.brim.app.showFrame(100);
      const source = document.querySelector('canvas.picture') as HTMLCanvasElement;
      const copy = document.createElement('canvas');
      copy.width = 48;
      copy.height = 32;
      const context = copy.getContext('2d')!;
      context.drawImage(source, 0, 0, 48, 32);
      const data = context.getImageData(0, 0, 48, 32).data;
      const seen = new Set<number>();
      for (let i = 0; i < data.length; i += 4)
        seen.add(((data[i]! >> 4) << 8) | ((data[i + 1]! >> 4) << 4) | (data[i + 2]! >> 4));
      return seen.size;
    });
    expect(colours).toBeGreaterThan(25);
    expect(
      o.requests.filter(
        (r) => !r.startsWith(o.server.url) && !r.startsWith('data:') && !r.startsWith('blob:'),
      ),
    ).toEqual([]);
    expect(o.problems).toEqual([]);
    await close(o);
  });

  test('plays, pauses, steps and scrubs by keyboard, buttons and slider', async () => {
    const o = await open(browser, fakeRun(40));
    await o.page.keyboard.press('ArrowRight');
    await o.page.keyboard.press('ArrowRight');
    expect(await frameOf(o)).toBe(2);
    await o.page.keyboard.press('Shift+ArrowRight');
    expect(await frameOf(o)).toBe(12);
    await o.page.keyboard.press('End');
    expect(await frameOf(o)).toBe(39);
    await o.page.keyboard.press('Home');
    expect(await frameOf(o)).toBe(0);
    await o.page.keyboard.press('Space');
    expect(await o.page.evaluate(() => window.brim.app.player.playing)).toBe(true);
    await until(o, () => window.brim.app.player.frame > 3);
    await o.page.getByRole('button', { name: 'pause' }).click();
    expect(await o.page.evaluate(() => window.brim.app.player.playing)).toBe(false);
    await o.page.locator('.scrub').fill('30');
    await until(o, () => window.brim.app.picture.shown?.index === 30);
    expect(await o.page.locator('.clock').innerText()).toContain('31 / 40');
    expect(o.problems).toEqual([]);
    await close(o);
  });

  test('hides and recolours bodies, shows contacts, tiles and attachments, and lists touching pairs', async () => {
    const o = await open(browser);
    await o.page.evaluate(() => window.brim.app.showFrame(130));
    await o.page.getByRole('button', { name: 'hide crate' }).click();
    expect(await o.page.getByRole('button', { name: 'show crate' }).count()).toBe(1);
    await o.page.locator('[data-body="2"] input[type=color]').fill('#ff0000');
    await o.page.keyboard.press('c');
    await o.page.keyboard.press('c');
    await o.page.keyboard.press('t');
    expect(await o.page.evaluate(() => window.brim.app.picture.links.object.visible)).toBe(true);
    await o.page.getByLabel(/what holds bodies/).uncheck();
    const state = await o.page.evaluate(() => ({
      style: window.brim.app.panel.contactStyle,
      tiles: window.brim.app.picture.tiles.object.visible,
      links: window.brim.app.picture.links.object.visible,
      looks: window.brim.app.panel.looks.map((l) => [l.visible, l.colour]),
    }));
    expect([state.style, state.tiles, state.links]).toEqual(['forces', true, false]);
    expect(state.looks[1]![0]).toBe(false);
    expect(state.looks[2]![1]).toBe('#ff0000');
    expect(await o.page.locator('.pairs tbody tr').allInnerTexts()).toHaveLength(2);
    expect(o.problems).toEqual([]);
    await close(o);
  });

  test('a surface that changes has other triangles in every frame', async () => {
    const o = await open(browser, fakeRun(10));
    const drawn = (f: number) =>
      o.page.evaluate(async (frame) => {
        const { app } = window.brim;
        for (const [body] of app.panel.looks.entries())
          app.picture.setLook(body, {
            visible: body === 6,
            colour: '#3070b0',
            wireframe: false,
            surface: false,
          });
        await app.showFrame(frame);
        const { cells, positions } = app.picture.shown!;
        return [cells.get(6)!.length / 3, positions.get(6)!.length / 3, app.picture.pointsOf(6)];
      }, f);
    expect(await drawn(0)).toEqual([72, 49, 49]);
    expect(await drawn(3)).toEqual([162, 100, 100]);
    expect(o.problems).toEqual([]);
    await close(o);
  });

  test('particles turn into the surface around them and back, and contacts into voxels', async () => {
    const o = await open(browser);
    const drawn = () => o.page.evaluate(() => window.brim.app.picture.stage.renderer.info.render.triangles);
    await o.page.evaluate(() => window.brim.app.showFrame(120));
    const balls = await o.page.evaluate(() => window.brim.app.png(120));
    await o.page.getByRole('button', { name: /^surface around the particles/ }).click();
    const surface = await o.page.evaluate(() => window.brim.app.png(120));
    expect(surface).not.toBe(balls);
    const kinds = await o.page.evaluate(() => {
      const kinds: string[] = [];
      window.brim.app.picture.stage.scene.traverse((x) => {
        if (x.parent?.userData.body !== undefined) kinds.push(x.type);
      });
      return kinds;
    });
    expect(kinds).toContain('Mesh');
    await o.page.getByRole('button', { name: /^surface around the particles/ }).click();
    expect(await o.page.evaluate(() => window.brim.app.png(120))).toBe(balls);
    const before = await drawn();
    await o.page.getByRole('button', { name: 'voxels' }).click();
    await o.page.evaluate(() => window.brim.app.showFrame(120));
    const count = await o.page.evaluate(() => window.brim.app.picture.shown!.contacts.count);
    expect(count).toBeGreaterThan(0);
    expect((await drawn()) - before).toBe(24 * count); // a box and its ghost
    expect(o.problems).toEqual([]);
    await close(o);
  });

  test('a slice follows its axis, its slider and the frame, and cuts the bodies open', async () => {
    const o = await open(browser);
    const slice = () =>
      o.page.evaluate(() => {
        const { slice } = window.brim.app.picture;
        return { visible: slice.object.visible, axis: slice.shown?.axis, at: slice.shown?.at };
      });
    await o.page.evaluate(() => window.brim.app.showFrame(60));
    expect((await slice()).visible).toBe(false);
    await o.page.keyboard.press('d');
    await until(o, () => window.brim.app.picture.slice.shown?.axis === 1);
    await o.page.keyboard.press('z');
    await until(o, () => window.brim.app.picture.slice.shown?.axis === 2);
    await o.page.getByRole('slider', { name: 'place of the slice' }).fill('0.5');
    await until(o, () => Math.abs(window.brim.app.picture.slice.shown!.at - 0.65) < 0.05);
    expect(await o.page.locator('.slice .facts').innerText()).toContain('nodes');
    // The picture with the slice differs from the one without.
    const shot = () => o.page.evaluate(() => window.brim.app.png(60));
    const withSlice = await shot();
    await o.page.keyboard.press('d');
    expect((await slice()).visible).toBe(false);
    expect(await shot()).not.toBe(withSlice);
    expect(o.problems).toEqual([]);
    await close(o);
  });

  test('stress colours elastic solids, by the largest of the frame or up to a number', async () => {
    const o = await open(browser);
    const shot = () => o.page.evaluate(() => window.brim.app.png(60));
    const plain = await shot();
    await o.page.keyboard.press('m');
    await until(o, () => window.brim.app.panel.stress.top > 0);
    const coloured = await shot();
    expect(coloured).not.toBe(plain);
    const top = () => o.page.evaluate(() => window.brim.app.panel.stress.top);
    const most = await top();
    await o.page.getByRole('spinbutton', { name: 'stress of the last colour' }).fill(String(10 * most));
    expect(await top()).toBeCloseTo(10 * most, 3);
    expect(await shot()).not.toBe(coloured);
    expect(await o.page.locator('.stress .facts').innerText()).toContain('largest');
    await o.page.keyboard.press('m');
    expect(await shot()).toBe(plain);
    expect(o.problems).toEqual([]);
    await close(o);
  });

  test('a run whose writer is gone is called cut short', async () => {
    const o = await open(browser, fakeRun(5, false));
    expect(await o.page.locator('.status').innerText()).toContain('growing');
    o.run.complete = o.run.stopped = true;
    await until(o, () => window.brim.app.run!.stopped === true);
    expect(await o.page.locator('.status').innerText()).toContain('cut short');
    await close(o);
  });

  test('a click on a body reads its numbers, a click on nothing closes them', async () => {
    const o = await open(browser);
    await o.page.evaluate(() => {
      window.brim.app.setPose({ azimuth: -90, elevation: 20 });
      window.brim.app.picture.stage.draw(true);
    });
    const found = await o.page.evaluate(() => {
      for (let y = 0.8; y > -0.8; y -= 0.05)
        for (let x = -0.8; x < 0.8; x += 0.05) {
          window.brim.app.pickAt(x, y);
          if (document.querySelector('.pick h3')?.textContent?.startsWith('jelly ball')) return true;
        }
      return false;
    });
    expect(found).toBe(true);
    expect(await o.page.locator('.pick').innerText()).toContain('nearest point');
    // The view goes with the body, and stays where it is after "f".
    await o.page.locator('.pick .follow').click();
    const offCentre = (frame: number) =>
      o.page.evaluate(async (f) => {
        const { app } = window.brim;
        await app.showFrame(f);
        const p = app.picture.shown!.positions.get(app.picture.following ?? -1) ?? new Float32Array(0);
        const target = app.picture.stage.controls.target.toArray();
        const off = [0, 1, 2].map((k) => {
          const along = p.filter((_, i) => i % 3 === k);
          return target[k]! - (Math.min(...along) + Math.max(...along)) / 2;
        });
        return { following: app.picture.following, target, off: Math.max(...off.map(Math.abs)) };
      }, frame);
    const [before, after] = [await offCentre(0), await offCentre(30)];
    expect(Math.max(before.off, after.off)).toBeLessThan(1e-6);
    expect(after.target).not.toEqual(before.target);
    expect(await o.page.locator('.pick .follow').innerText()).toBe('stop following');
    await o.page.evaluate(() => window.brim.app.fit());
    expect(await o.page.locator('.pick .follow').innerText()).toBe('follow this body');
    expect((await offCentre(60)).following).toBe(undefined);
    await o.page.evaluate(() => window.brim.app.pickAt(-0.99, 0.99));
    expect(await o.page.locator('.pick').isVisible()).toBe(false);
    await close(o);
  });

  test('a growing run shows new frames and follows its end', async () => {
    const o = await open(browser, fakeRun(5, false));
    expect(await o.page.locator('.status').innerText()).toContain('growing');
    await o.page.keyboard.press('End');
    o.run.frames = 9;
    await until(o, () => window.brim.app.player.frames === 9 && window.brim.app.player.frame === 8);
    o.run.frames = 12;
    o.run.complete = true;
    await until(o, () => window.brim.app.player.frames === 12 && window.brim.app.run!.complete);
    expect(await o.page.locator('.status').innerText()).toContain('complete');
    expect(o.problems).toEqual([]);
    await close(o);
  });

  test('a run without frames says so, and comes alive with its first ones', async () => {
    const o = await open(browser, fakeRun(0, false));
    expect(await notice(o, 'empty').innerText()).toContain('No frames yet');
    await o.page.keyboard.press('Space');
    await o.page.keyboard.press('End');
    o.run.frames = 3;
    await until(o, () => window.brim.app.picture.shown?.index === 0);
    expect(await notice(o, 'empty').count()).toBe(0);
    expect(o.problems).toEqual([]);
    await close(o);
  });

  test('a damaged frame is named, and the rest still plays', async () => {
    const run = fakeRun(20);
    run.broken.add(7);
    const o = await open(browser, run);
    await o.page.locator('.scrub').fill('7');
    await notice(o, 'frame').waitFor();
    expect(await notice(o, 'frame').innerText()).toContain('Frame 8 cannot be shown: frame 7 cannot be read');
    await o.page.keyboard.press('ArrowRight');
    await until(o, () => window.brim.app.picture.shown?.index === 8);
    expect(await notice(o, 'frame').count()).toBe(0);
    expect(o.problems).toEqual([]);
    await close(o);
  });

  test('a lost server is told, what is loaded still shows, and its return is noticed', async () => {
    const o = await open(browser, fakeRun(20));
    await o.page.evaluate(() => window.brim.app.showFrame(3));
    const { port } = o.server;
    await o.server.stop();
    await notice(o, 'lost').waitFor();
    expect(await notice(o, 'lost').innerText()).toContain('does not answer');
    await o.page.locator('.scrub').fill('0');
    await until(o, () => window.brim.app.picture.shown?.index === 0);
    await o.page.locator('.scrub').fill('15'); // not loaded
    o.server = await startFakeServer(o.run, folder, port);
    await notice(o, 'lost').waitFor({ state: 'detached' });
    await until(o, () => window.brim.app.picture.shown?.index === 15);
    expect(o.problems).toEqual([]);
    await close(o);
  });

  test('pointing at a plot marks the moment on the time line, clicking goes there', async () => {
    const o = await open(browser, fakeRun(50));
    const box = (await o.page.locator('.plot').first().boundingBox())!;
    await o.page.mouse.move(box.x + box.width / 2, box.y + 20);
    expect(await o.page.locator('.ghost').isVisible()).toBe(true);
    await o.page.mouse.down();
    await o.page.mouse.up();
    expect(Math.abs((await frameOf(o)) - 25)).toBeLessThanOrEqual(1);
    await close(o);
  });

  test('saves a picture and a zip of all pictures', async () => {
    const o = await open(browser, fakeRun(3), { width: 700, height: 420 });
    const [picture] = await Promise.all([o.page.waitForEvent('download'), o.page.keyboard.press('s')]);
    expect(picture.suggestedFilename()).toBe('made-up_run_00000.png');
    const [pictures] = await Promise.all([o.page.waitForEvent('download'), o.page.getByText('PNGs').click()]);
    expect(pictures.suggestedFilename()).toBe('made-up_run.zip');
    expect(await shownOf(o)).toBe(2);
    expect(o.problems).toEqual([]);
    await close(o);
  });

  test('films the run once through', async () => {
    const o = await open(browser, fakeRun(12), { width: 700, height: 420 });
    const [film] = await Promise.all([
      o.page.waitForEvent('download'),
      o.page.getByRole('button', { name: 'film the run' }).click(),
    ]);
    expect(film.suggestedFilename()).toBe('made-up_run.webm');
    // The browser itself plays what was saved: the run's own time, and the picture at the end.
    const bytes = (await readFile(await film.path())).toString('base64');
    const played = await o.page.evaluate(async (data) => {
      const video = document.createElement('video');
      video.src = `data:video/webm;base64,${data}`;
      await new Promise((done, fail) => {
        video.onloadeddata = done;
        video.onerror = () => fail(new Error(video.error?.message ?? 'no film'));
      });
      const { player } = window.brim.app;
      return { film: video.duration, run: player.time(11) - player.time(0), wide: video.videoWidth };
    }, bytes);
    expect(played.film).toBeGreaterThanOrEqual(played.run);
    expect(played.film).toBeLessThan(played.run * (13 / 11));
    expect(played.wide).toBeGreaterThan(100);
    expect(o.problems).toEqual([]);
    await close(o);
  });

  test('on a phone the picture has the whole width and the panels open over it', async () => {
    const o = await open(browser, fakeRun(5), { width: 400, height: 700 });
    expect((await o.page.locator('.view').boundingBox())!.width).toBe(400);
    await o.page.keyboard.press('b');
    expect(await o.page.locator('.left').isVisible()).toBe(true);
    await o.page.keyboard.press('p');
    expect(await o.page.locator('.left').isVisible()).toBe(false);
    expect(await o.page.evaluate(() => document.documentElement.scrollWidth)).toBeLessThanOrEqual(400);
    await close(o);
  });

  test('pulls bodies of a run that is being made, and turns the view by all else', async () => {
    const run = fakeRun(20, false);
    run.interactive = true;
    const o = await open(browser, run);
    expect(await frameOf(o)).toBe(19);
    await until(o, () => window.brim.app.picture.shown?.index === 19);
    expect(await o.page.locator('.head').innerText()).toContain('drag a body to pull it');
    const held = await o.page.evaluate(() => {
      const { picture } = window.brim.app;
      const canvas = document.querySelector('canvas.picture') as HTMLCanvasElement;
      const box = canvas.getBoundingClientRect();
      for (let y = -0.9; y < 0.9; y += 0.04)
        for (let x = -0.9; x < 0.9; x += 0.04) {
          const picked = picture.pick(x, y);
          if (picked?.body && !picked.body.fixed && picked.body.name === 'crate')
            return {
              body: picked.body.index,
              x: box.left + (0.5 + 0.5 * x) * box.width,
              y: box.top + (0.5 - 0.5 * y) * box.height,
            };
        }
      throw new Error('no crate in the picture');
    });
    const poseOf = () => o.page.evaluate(() => window.brim.app.picture.stage.camera.position.toArray());
    const before = await poseOf();
    const drag = async (from: { x: number; y: number }) => {
      await o.page.mouse.move(from.x, from.y);
      await o.page.mouse.down();
      await o.page.mouse.move(from.x + 30, from.y - 20, { steps: 3 });
      await o.page.mouse.up();
    };
    await drag(held);
    await expect.poll(() => run.asked.at(-1)).toBe('release');
    expect(run.asked[0]).toMatch(new RegExp(`^grab\\?body=${held.body}&vertex=\\d+&x=`));
    expect(run.asked.some((wish) => wish.startsWith('pull?x='))).toBe(true);
    expect(await poseOf()).toEqual(before);
    // A click reads numbers as before, and takes hold of nothing.
    const asked = run.asked.length;
    await o.page.mouse.click(held.x, held.y);
    await o.page.locator('.pick').waitFor();
    expect(run.asked.length).toBe(asked);
    await o.page.locator('.pick').getByRole('button', { name: 'close' }).click();
    // At a frame of the past the drag turns the view.
    await o.page.keyboard.press('Home');
    await drag(held);
    await expect.poll(poseOf, { timeout: 30_000 }).not.toEqual(before);
    expect(run.asked.length).toBe(asked);
    expect(o.problems).toEqual([]);
    await close(o);
  });
});
