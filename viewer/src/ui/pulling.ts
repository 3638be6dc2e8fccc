/** Bodies of a run that is being made are pulled about by dragging them. */
import * as THREE from 'three';
import { askHand, ServerError, type HandWish } from '../client';
import type { Picture } from '../picture';
import type { BodyInfo, RunInfo } from '../run';
import { PullView } from '../scene/pull_view';
import type { Notices } from './notices';

const kDrag = 4; // [CSS pixels] from which a click is a drag

/** What the pointer holds. */
interface Grip {
  body: BodyInfo;
  vertex: number;
  offset: THREE.Vector3; // [m] of the place from the vertex, as it was grabbed
  plane: THREE.Plane; // through the place, facing the camera: the pointer moves in it
  to: THREE.Vector3;
  from: { x: number; y: number }; // [CSS pixels]
  dragged: boolean;
  sent: boolean;
}

/** True for what can be taken hold of: fluids have no points, and what is fixed does not move. */
export const canGrab = (body: BodyInfo): boolean => !body.fixed && !body.kind.endsWith('_fluid');

export class Pulling {
  private grip: Grip | undefined;
  private readonly view = new PullView();
  private wishes: HandWish[] = []; // that wait for the server, in order
  private sending = false;

  /** @param live whether the picture shows a run that can be acted on, at its last frame */
  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly picture: Picture,
    private readonly notices: Notices,
    private readonly live: () => RunInfo | undefined,
  ) {
    picture.stage.scene.add(this.view.object);
    // Before the camera's own listeners: what is grabbed does not turn the view.
    canvas.addEventListener('pointerdown', (e) => this.down(e), { capture: true });
    canvas.addEventListener('pointermove', (e) => this.move(e));
    for (const end of ['pointerup', 'pointercancel', 'lostpointercapture'] as const)
      canvas.addEventListener(end, () => this.up());
  }

  private at(e: PointerEvent): THREE.Vector2 {
    const box = this.canvas.getBoundingClientRect();
    return new THREE.Vector2(
      (2 * (e.clientX - box.left)) / box.width - 1,
      1 - (2 * (e.clientY - box.top)) / box.height,
    );
  }

  private down(e: PointerEvent) {
    if (e.button !== 0 || e.shiftKey || e.ctrlKey || e.metaKey || !this.live()) return;
    const { x, y } = this.at(e);
    const picked = this.picture.pick(x, y);
    const vertex = picked?.vertex ?? -1;
    const place = picked?.body && this.picture.positionOf(picked.body.index, vertex);
    if (!picked?.body || !place || !canGrab(picked.body)) return;
    const facing = this.picture.stage.camera.getWorldDirection(new THREE.Vector3());
    this.grip = {
      body: picked.body,
      vertex,
      offset: picked.at.clone().sub(new THREE.Vector3(...place)),
      plane: new THREE.Plane().setFromNormalAndCoplanarPoint(facing, picked.at),
      to: picked.at.clone(),
      from: { x: e.clientX, y: e.clientY },
      dragged: false,
      sent: false,
    };
    this.picture.stage.controls.enabled = false;
    this.canvas.setPointerCapture(e.pointerId);
  }

  private move(e: PointerEvent) {
    const { grip } = this;
    if (!grip) return;
    grip.dragged ||= Math.hypot(e.clientX - grip.from.x, e.clientY - grip.from.y) > kDrag;
    if (!grip.dragged) return;
    const ray = new THREE.Raycaster();
    ray.setFromCamera(this.at(e), this.picture.stage.camera);
    ray.ray.intersectPlane(grip.plane, grip.to); // where the plane is not met, the place before stays
    if (!grip.sent) {
      grip.sent = true;
      const { x, y, z } = grip.offset;
      this.ask({ what: 'grab', body: grip.body.index, vertex: grip.vertex, x, y, z });
    }
    this.ask({ what: 'pull', x: grip.to.x, y: grip.to.y, z: grip.to.z });
    this.refresh();
  }

  private up() {
    const { grip } = this;
    if (!grip) return;
    this.grip = undefined;
    this.picture.stage.controls.enabled = true;
    if (grip.sent) this.ask({ what: 'release' });
    this.view.hide();
    this.picture.stage.invalidate();
  }

  /** Draws the spring where the body is now. */
  refresh(): void {
    const { grip } = this;
    if (!grip?.sent) return;
    const place = this.picture.positionOf(grip.body.index, grip.vertex);
    if (place)
      this.view.show(new THREE.Vector3(...place).add(grip.offset), grip.to, this.picture.stage.radius);
    this.picture.stage.invalidate();
  }

  /** One wish at a time is on its way; of places to pull to that wait, the last counts. */
  private ask(wish: HandWish) {
    if (wish.what === 'pull' && this.wishes.at(-1)?.what === 'pull') this.wishes.pop();
    this.wishes.push(wish);
    if (!this.sending) void this.send();
  }

  private async send() {
    this.sending = true;
    for (let wish = this.wishes.shift(); wish; wish = this.wishes.shift()) {
      try {
        await askHand(wish);
        this.notices.set('hand');
      } catch (error) {
        // A busy run takes it later: what is held must be let go.
        if (error instanceof ServerError && error.status === 503 && this.live()) {
          if (wish.what !== 'pull' || this.wishes.length === 0) this.wishes.unshift(wish);
          await new Promise((done) => setTimeout(done, 100));
        } else {
          this.notices.set('hand', `The body cannot be pulled: ${(error as Error).message}`);
          this.wishes = [];
        }
      }
    }
    this.sending = false;
  }
}
