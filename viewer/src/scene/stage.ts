/** The studio: renderer, camera, lights, ground and background. z is up, lengths are in metres. */
import * as THREE from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';
import { Ground } from './ground';
import { studioLight } from './studio_light';

export interface CameraPose {
  azimuth: number; // [degrees] from +x towards +y
  elevation: number; // [degrees] above the ground
  distance?: number; // [m] to the middle of the scene; fits the scene when absent
}

export const defaultPose: CameraPose = { azimuth: -62, elevation: 20 };

/** A soft vertical gradient, drawn behind everything and left alone by the tone mapping. */
function backdrop(): THREE.Texture {
  const canvas = document.createElement('canvas');
  canvas.width = 4;
  canvas.height = 256;
  const context = canvas.getContext('2d')!;
  const gradient = context.createLinearGradient(0, 0, 0, 256);
  gradient.addColorStop(0, '#c9d3dc');
  gradient.addColorStop(0.45, '#e6eaec');
  gradient.addColorStop(1, '#f3f2ef');
  context.fillStyle = gradient;
  context.fillRect(0, 0, 4, 256);
  const texture = new THREE.CanvasTexture(canvas);
  texture.colorSpace = THREE.SRGBColorSpace;
  return texture;
}

/** @param size [pixels] of the shadow's map @param radius [pixels] of its blur */
function castShadow(light: THREE.DirectionalLight, size: number, radius: number, samples: number) {
  light.castShadow = true;
  light.shadow.mapSize.set(size, size);
  light.shadow.radius = radius;
  light.shadow.blurSamples = samples;
  light.shadow.bias = -0.0004;
}

export class Stage {
  readonly scene = new THREE.Scene();
  readonly camera = new THREE.PerspectiveCamera(32, 1, 0.01, 100);
  readonly renderer: THREE.WebGLRenderer;
  readonly controls: OrbitControls;
  readonly ground = new Ground();
  // The key comes from one side of the usual view, so that shadows fall beside things and show how high they are; the
  // sky's soft shadow from straight above darkens the ground under them.
  private readonly key = new THREE.DirectionalLight('#fff2e2', 2.1);
  private readonly sky = new THREE.DirectionalLight('#f2f6ff', 0.75);
  private readonly fill = new THREE.DirectionalLight('#dfeaff', 0.5);
  private readonly box = new THREE.Box3(new THREE.Vector3(-1, -1, 0), new THREE.Vector3(1, 1, 1));
  private readonly bounds = new THREE.Sphere();
  /** Called before each drawing, when the camera is where it will be. */
  beforeDraw: () => void = () => undefined;
  private dirty = true;
  private fitted = false; // the whole scene is shown; once a person moves the camera, it stays where it was put

  constructor(readonly canvas: HTMLCanvasElement) {
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, preserveDrawingBuffer: true });
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    // Keeps the hues, so that bodies look as their colour in the list does.
    this.renderer.toneMapping = THREE.NeutralToneMapping;
    this.renderer.toneMappingExposure = 1.0;
    this.renderer.localClippingEnabled = true;
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = THREE.VSMShadowMap;
    this.renderer.shadowMap.autoUpdate = false; // only when something other than the camera has moved

    this.scene.environment = studioLight(this.renderer);
    this.scene.environmentIntensity = 0.3;
    this.scene.environmentRotation.set(Math.PI / 2, 0, 0); // environment maps are y up
    this.scene.background = backdrop();

    castShadow(this.key, 1024, 4, 9);
    castShadow(this.sky, 256, 7, 12);
    this.sky.shadow.intensity = 0.6;
    for (const light of [this.key, this.sky, this.fill]) this.scene.add(light, light.target);
    this.scene.add(this.ground.object);

    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.enableDamping = true;
    this.controls.dampingFactor = 0.12;
    this.controls.maxPolarAngle = Math.PI * 0.98;
    this.controls.addEventListener('change', () => (this.dirty = true));
    this.controls.addEventListener('start', () => (this.fitted = false));
    this.setBounds(this.box);
    this.setPose(defaultPose);
  }

  /** Fits light, ground and clipping to a box that holds what is to be seen. */
  setBounds(box: THREE.Box3): void {
    this.box.copy(box);
    const center = box.getCenter(this.bounds.center);
    const r = (this.bounds.radius = Math.max(0.5 * box.min.distanceTo(box.max), 1e-6));
    for (const [light, towards] of [
      [this.key, new THREE.Vector3(-0.62, -0.55, 0.85)],
      [this.sky, new THREE.Vector3(0.05, -0.05, 1)],
      [this.fill, new THREE.Vector3(0.8, -0.5, 0.35)],
    ] as const) {
      light.position.copy(center).addScaledVector(towards.normalize(), 4 * r);
      light.target.position.copy(center);
      if (!light.castShadow) continue;
      const seen = light.shadow.camera;
      seen.left = seen.bottom = -1.35 * r;
      seen.right = seen.top = 1.35 * r;
      seen.near = r;
      seen.far = 8 * r;
      seen.updateProjectionMatrix();
      light.shadow.normalBias = 0.004 * r;
    }
    this.ground.place(center, r, box);
    this.camera.near = r / 200;
    this.camera.far = r * 100;
    this.camera.updateProjectionMatrix();
    this.controls.minDistance = r * 0.02;
    this.controls.maxDistance = r * 30;
    this.invalidate();
  }

  /** A floor of the scene's own, at a height, takes the place of the studio's; the grid lies on it. */
  setFloor(height: number | undefined): void {
    this.ground.setFloor(height, this.bounds.radius);
    this.invalidate();
  }

  /** Middle of what is to be seen. */
  get center(): THREE.Vector3 {
    return this.bounds.center;
  }

  get radius(): number {
    return this.bounds.radius;
  }

  /** Looks at the middle of the scene from a direction; from as far as shows all of it, unless told how far. */
  setPose(pose: CameraPose): void {
    const a = THREE.MathUtils.degToRad(pose.azimuth);
    const e = THREE.MathUtils.degToRad(Math.max(-89.9, Math.min(89.9, pose.elevation)));
    const direction = new THREE.Vector3(Math.cos(e) * Math.cos(a), Math.cos(e) * Math.sin(a), Math.sin(e));
    const distance = pose.distance ?? this.fittingDistance(direction);
    this.fitted = pose.distance === undefined;
    this.controls.target.copy(this.bounds.center);
    this.camera.position.copy(this.bounds.center).addScaledVector(direction, distance);
    this.controls.update();
    this.invalidate();
  }

  /** How far away, in a direction, every corner of the box comes into the picture, with a margin. */
  private fittingDistance(direction: THREE.Vector3): number {
    const right = new THREE.Vector3().crossVectors(this.camera.up, direction).normalize();
    const up = new THREE.Vector3().crossVectors(direction, right);
    const tanUp = 0.94 * Math.tan(THREE.MathUtils.degToRad(this.camera.fov / 2));
    const tanRight = tanUp * this.camera.aspect;
    let distance = 0;
    for (let i = 0; i < 8; ++i) {
      const { min, max } = this.box;
      const p = new THREE.Vector3(i & 1 ? max.x : min.x, i & 2 ? max.y : min.y, i & 4 ? max.z : min.z);
      p.sub(this.bounds.center);
      const needed = Math.max(Math.abs(p.dot(right)) / tanRight, Math.abs(p.dot(up)) / tanUp);
      distance = Math.max(distance, p.dot(direction) + needed);
    }
    return Math.max(distance, 0.1 * this.bounds.radius);
  }

  /** Looks at another point from the same direction and distance. */
  lookAt(target: THREE.Vector3): void {
    this.camera.position.add(target).sub(this.controls.target);
    this.controls.target.copy(target);
    this.fitted = false;
    this.controls.update();
    this.invalidate();
  }

  /** Keeps the direction of the view and brings the whole scene into it. */
  fit(): void {
    const d = this.camera.position.clone().sub(this.controls.target);
    this.setPose({
      azimuth: THREE.MathUtils.radToDeg(Math.atan2(d.y, d.x)),
      elevation: THREE.MathUtils.radToDeg(Math.asin(d.z / (d.length() || 1))),
    });
  }

  /** Takes the size of the picture; in CSS pixels when the canvas is on the page, exact when a ratio is given. */
  resize(width: number, height: number, pixelRatio = Math.min(window.devicePixelRatio, 2)): void {
    this.renderer.setPixelRatio(pixelRatio);
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / Math.max(1, height);
    this.camera.updateProjectionMatrix();
    if (this.fitted) this.fit();
    this.invalidate();
  }

  /** Something in the scene has changed: picture and shadows are drawn anew. */
  invalidate(): void {
    this.dirty = true;
    this.renderer.shadowMap.needsUpdate = true;
  }

  /** Draws if anything changed since the last call. */
  draw(force = false): boolean {
    this.controls.update();
    if (!this.dirty && !force) return false;
    this.dirty = false;
    this.beforeDraw();
    this.renderer.render(this.scene, this.camera);
    return true;
  }
}
