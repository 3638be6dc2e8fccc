/** The picture of a run: bodies, contacts and tiles on the stage, for one frame at a time. */
import * as THREE from 'three';
import { contactSteps, type BodyInfo, type Frame, type LinkInfo, type RunInfo, type Topology } from './run';
import { makeBodyView, type BodyView } from './scene/body_view';
import { boxOf, boxWithoutStrays, framing } from './scene/bounds';
import { ContactView, type ContactStyle } from './scene/contact_view';
import { LinkView, linkBox } from './scene/link_view';
import { defaultColours } from './scene/palette';
import { Stage } from './scene/stage';
import { SliceView } from './scene/slice_view';
import { TileView } from './scene/tile_view';
import type { Slice } from './slice';
import { stressColours, type Stress } from './stress';

/** How a person wants to see a body. */
export interface BodyLook {
  visible: boolean;
  colour: string;
  wireframe: boolean;
  surface: boolean; // particles as the surface around them
}

export interface Picked {
  at: THREE.Vector3;
  body?: BodyInfo;
  vertex?: number; // nearest vertex of the body
  contact?: number;
}

export class Picture {
  readonly stage: Stage;
  contacts: ContactView | undefined;
  readonly tiles = new TileView();
  readonly links = new LinkView();
  readonly slice = new SliceView();
  private cut = true; // bodies are cut open where the slice is
  colours: string[] = [];
  shown: Frame | undefined;
  private views: BodyView[] = [];
  private bodies: BodyInfo[] = [];
  private parts: RunInfo['parts'] = [];
  private linkInfos: LinkInfo[] = [];
  private positions: (Float32Array | undefined)[] = [];
  private cells: Int32Array[] = [];
  private fixedBoxes: THREE.Box3[] = [];
  private start = new THREE.Box3(); // of what moves, in the first frame
  private followed: number | undefined; // body that the view goes with
  /** Called when the view goes with another body, or with none. */
  followChanged: () => void = () => undefined;

  constructor(canvas: HTMLCanvasElement) {
    this.stage = new Stage(canvas);
    this.stage.scene.add(this.tiles.object, this.links.object, this.slice.object);
    this.stage.beforeDraw = () => this.slice.face(this.stage.camera.position);
  }

  /** Takes the bodies; `samples` are a few frames over the run, to know how large it is. */
  setRun(run: RunInfo, topologies: Topology[], samples: Frame[]): void {
    for (const view of this.views) {
      this.stage.scene.remove(view.object);
      view.dispose();
    }
    this.views = [];
    if (this.contacts) this.stage.scene.remove(this.contacts.object);
    this.bodies = run.bodies;
    this.parts = run.parts;
    this.linkInfos = run.links ?? [];
    this.colours = defaultColours(run.bodies);
    this.contacts = new ContactView((part) => run.bodies[run.parts[part]?.body ?? -1]?.fixed ?? false);
    this.stage.scene.add(this.contacts.object);
    this.fixedBoxes = topologies.flatMap((t) => (t.positions ? [boxOf(t.positions)] : []));
    this.stage.ground.standing = run.bodies.some((b) => b.fixed);
    this.followed = undefined;
    this.start.makeEmpty();
    this.frameScene(samples);
    this.views = run.bodies.map((body, i) => {
      const view = makeBodyView(body, topologies[i]!, this.colours[i]!, 0.003 * this.stage.radius, () =>
        this.stage.invalidate(),
      );
      view.object.userData.body = i;
      view.object.visible = false; // until its positions are known
      this.stage.scene.add(view.object);
      return view;
    });
    this.positions = topologies.map((t) => t.positions);
    this.cells = topologies.map((t) => t.cells);
    topologies.forEach((t, i) => {
      if (!t.positions) return;
      this.views[i]!.update(t.positions);
      this.views[i]!.object.visible = true;
    });
    this.findFloors();
    this.shown = undefined;
    this.stage.invalidate();
  }

  /** Fits light and ground to what some frames show; the first time the first of them begins the run. */
  frameScene(samples: Frame[]): void {
    if (this.start.isEmpty() && samples[0]) this.start = this.movingBox(samples[0]);
    const boxes = samples.map((s) => {
      const box = this.movingBox(s);
      return this.links.object.visible ? box.union(linkBox(s.links, this.linkInfos, box)) : box;
    });
    const box = framing(boxes, this.fixedBoxes, this.start);
    if (box.isEmpty()) return;
    this.stage.setBounds(box);
    this.findFloors();
  }

  /** Middle of what moves in the frame shown, [m]; that of the scene where nothing does. */
  middle(): [number, number, number] {
    const box = this.shown ? this.movingBox(this.shown) : new THREE.Box3();
    return (box.isEmpty() ? this.stage.center : box.getCenter(new THREE.Vector3())).toArray();
  }

  private movingBox(frame: Frame): THREE.Box3 {
    const box = new THREE.Box3();
    for (const [body, p] of frame.positions) {
      const own = this.bodies[body]?.display === 'points' ? boxWithoutStrays(p) : boxOf(p);
      if (!own.isEmpty()) box.union(own.expandByScalar(this.bodies[body]?.radius ?? 0));
    }
    return box;
  }

  /** Fixed bodies that are flat, level and wider than the scene stand for endless floors. */
  private findFloors() {
    let height: number | undefined;
    this.positions.forEach((p, i) => {
      if (!p || !this.bodies[i]?.fixed || !this.views[i]?.asFloor) return;
      const size = boxOf(p).getSize(new THREE.Vector3());
      if (!(size.z < 1e-5 * Math.min(size.x, size.y)) || Math.min(size.x, size.y) < 1.5 * this.stage.radius)
        return;
      const middle = this.stage.center;
      const box = boxOf(p);
      const reach = Math.min(
        5 * this.stage.radius,
        middle.x - box.min.x,
        box.max.x - middle.x,
        middle.y - box.min.y,
        box.max.y - middle.y,
      );
      if (reach < this.stage.radius) return;
      this.views[i].asFloor(new THREE.Vector3(middle.x, middle.y, p[2]!), reach);
      height = Math.max(height ?? -Infinity, p[2]!);
    });
    this.stage.setFloor(height);
  }

  show(frame: Frame, visible: (body: number) => boolean): void {
    this.shown = frame;
    for (const [body, positions] of frame.positions) {
      this.positions[body] = positions;
      this.views[body]?.update(positions, frame.cells.get(body));
    }
    this.views.forEach((view, body) => (view.object.visible = visible(body) && this.present(body)));
    this.goAlong();
    this.refreshContacts();
    this.tiles.update(frame.tiles);
    this.refreshLinks();
    this.stage.invalidate();
  }

  /** Keeps a body in the middle of the view from now on, or none. */
  follow(body: number | undefined): void {
    this.followed = body;
    this.goAlong();
    this.followChanged();
  }

  get following(): number | undefined {
    return this.followed;
  }

  private goAlong() {
    if (this.followed === undefined || !this.present(this.followed)) return;
    const box = boxOf(this.positions[this.followed]!);
    if (!box.isEmpty()) this.stage.lookAt(box.getCenter(new THREE.Vector3()));
  }

  /** The frame shown has the body. */
  private present(body: number): boolean {
    return this.positions[body] !== undefined && !this.shown?.removed.has(body);
  }

  setLook(body: number, look: BodyLook): void {
    const view = this.views[body];
    if (!view) return;
    view.object.visible = look.visible && this.present(body);
    view.setColour(look.colour);
    view.setWireframe(look.wireframe);
    view.setSurface?.(look.surface);
    this.stage.invalidate();
  }

  /** Comes true when everything that is made beside the page is in the picture. */
  async settled(): Promise<void> {
    await Promise.all(this.views.map((v) => v.settled?.()));
  }

  /** Shows a plane of densities, or none. @param colours of the bodies @param single whether it is of one body */
  setSlice(slice: Slice | undefined, colours: string[], single: boolean, cut: boolean): void {
    const before = this.slice.object.visible && this.cut;
    this.slice.object.visible = slice !== undefined;
    this.cut = cut;
    if (slice)
      this.slice.update(
        slice,
        colours,
        single,
        this.shown?.tiles ?? { key: new Int32Array(0), step: new Float32Array(0) },
      );
    const now = slice !== undefined && cut;
    if (now !== before) this.views.forEach((v) => v.setClipping(now ? [this.slice.clip] : null));
    this.stage.invalidate();
  }

  /** Colours elastic solids by their stress, or none. @param top [Pa] of the last colour */
  setStress(stress: Stress | undefined, top: number): void {
    this.views.forEach((view, body) => {
      const values = stress?.get(body);
      view.setValues?.(values && stressColours(values, top));
    });
    this.stage.invalidate();
  }

  setContacts(style: ContactStyle, scale: number): void {
    if (!this.contacts) return;
    this.contacts.style = style;
    this.contacts.scale = scale;
    this.refreshContacts();
    this.stage.invalidate();
  }

  private refreshContacts() {
    const { contacts, shown } = this;
    if (contacts && shown)
      contacts.update(shown.contacts, this.stage.radius, () =>
        contactSteps(shown.contacts, this.parts, shown.tiles.step),
      );
  }

  setTiles(on: boolean): void {
    this.tiles.object.visible = on;
    if (this.shown) this.tiles.update(this.shown.tiles);
    this.stage.invalidate();
  }

  setLinks(on: boolean): void {
    this.links.object.visible = on;
    this.refreshLinks();
    this.stage.invalidate();
  }

  private refreshLinks() {
    const { shown } = this;
    if (!shown) return;
    this.links.update(shown.links, this.linkInfos, this.stage.radius, (body) => {
      const positions = this.positions[body];
      const solid = this.bodies[body]?.display === 'triangles' && !this.bodies[body].twoSided;
      const triangles = shown.cells.get(body) ?? this.cells[body];
      return positions && triangles && solid ? { positions, triangles } : undefined;
    });
  }

  /** What lies under a point of the canvas, given in -1..1 from bottom left; contacts come before bodies. */
  pick(x: number, y: number): Picked | undefined {
    const ray = new THREE.Raycaster();
    ray.setFromCamera(new THREE.Vector2(x, y), this.stage.camera);
    const contact = this.contacts?.pick(ray) ?? -1;
    if (contact >= 0 && this.shown)
      return { at: new THREE.Vector3().fromArray(this.shown.contacts.position, 3 * contact), contact };
    const hit = ray.intersectObjects(
      this.views.map((v) => v.object).filter((o) => o.visible),
      true,
    )[0];
    if (!hit) return undefined;
    let object: THREE.Object3D | null = hit.object;
    while (object && object.userData.body === undefined) object = object.parent;
    const index = object?.userData.body as number | undefined;
    if (index === undefined) return undefined;
    return { at: hit.point, body: this.bodies[index]!, vertex: this.nearestVertex(index, hit.point) };
  }

  private nearestVertex(body: number, point: THREE.Vector3): number {
    const p = this.positions[body] ?? new Float32Array(0);
    let best = -1;
    let least = Infinity;
    for (let i = 0; i + 2 < p.length; i += 3) {
      const d = (p[i]! - point.x) ** 2 + (p[i + 1]! - point.y) ** 2 + (p[i + 2]! - point.z) ** 2;
      if (d < least) {
        least = d;
        best = i / 3;
      }
    }
    return best;
  }

  pointsOf(body: number): number {
    return (this.positions[body]?.length ?? 0) / 3;
  }

  positionOf(body: number, vertex: number): [number, number, number] | undefined {
    const p = this.positions[body];
    return p && vertex >= 0 ? [p[3 * vertex]!, p[3 * vertex + 1]!, p[3 * vertex + 2]!] : undefined;
  }
}
