/** The studio: renderer, camera, lights, ground and background. z is up, lengths are in metres. */
import * as THREE from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';
import { RoomEnvironment } from 'three/examples/jsm/environments/RoomEnvironment.js';
import { Ground } from './ground';

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

export class Stage {
  readonly scene = new THREE.Scene();
  readonly camera = new THREE.PerspectiveCamera(32, 1, 0.01, 100);
  readonly renderer: THREE.WebGLRenderer;
  readonly controls: OrbitControls;
  readonly ground = new Ground();
  private readonly key = new THREE.DirectionalLight('#fff4e6', 2.6);
  private readonly fill = new THREE.DirectionalLight('#dfeaff', 0.55);
  private readonly bounds = new THREE.Sphere(new THREE.Vector3(0, 0, 0.5), 1);
  private dirty = true;

  constructor(readonly canvas: HTMLCanvasElement) {
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, preserveDrawingBuffer: true });
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.renderer.toneMapping = THREE.AgXToneMapping;
    this.renderer.toneMappingExposure = 1.25;
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = THREE.VSMShadowMap;

    const pmrem = new THREE.PMREMGenerator(this.renderer);
    this.scene.environment = pmrem.fromScene(new RoomEnvironment(), 0.04).texture;
    this.scene.environmentIntensity = 0.55;
    this.scene.environmentRotation.set(Math.PI / 2, 0, 0); // the room is built y up
    this.scene.background = backdrop();

    this.key.castShadow = true;
    this.key.shadow.mapSize.set(2048, 2048);
    this.key.shadow.radius = 7;
    this.key.shadow.blurSamples = 16;
    this.key.shadow.bias = -0.0004;
    this.scene.add(this.key, this.key.target, this.fill, this.fill.target, this.ground.object);

    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.enableDamping = true;
    this.controls.dampingFactor = 0.12;
    this.controls.maxPolarAngle = Math.PI * 0.98;
    this.controls.addEventListener('change', () => this.invalidate());
    this.setBounds(this.bounds.center, this.bounds.radius, 0);
    this.setPose(defaultPose);
  }

  /** Fits light, ground and clipping to the scene: a ball that holds it, and the height of the ground. */
  setBounds(center: THREE.Vector3, radius: number, groundHeight: number): void {
    const r = Math.max(radius, 1e-6);
    this.bounds.set(center.clone(), r);
    const towards = new THREE.Vector3(0.45, -0.55, 1).normalize();
    this.key.position.copy(center).addScaledVector(towards, 4 * r);
    this.key.target.position.copy(center);
    this.fill.position.copy(center).add(new THREE.Vector3(-3 * r, -1.5 * r, 1.2 * r));
    this.fill.target.position.copy(center);
    const box = this.key.shadow.camera;
    box.left = box.bottom = -1.35 * r;
    box.right = box.top = 1.35 * r;
    box.near = r;
    box.far = 8 * r;
    box.updateProjectionMatrix();
    this.key.shadow.normalBias = 0.004 * r;
    this.ground.place(center, r, groundHeight);
    this.camera.near = r / 200;
    this.camera.far = r * 100;
    this.camera.updateProjectionMatrix();
    this.controls.minDistance = r * 0.02;
    this.controls.maxDistance = r * 30;
    this.invalidate();
  }

  get radius(): number {
    return this.bounds.radius;
  }

  /** Looks at the middle of the scene from a direction; from as far as shows all of it, unless told how far. */
  setPose(pose: CameraPose): void {
    const a = THREE.MathUtils.degToRad(pose.azimuth);
    const e = THREE.MathUtils.degToRad(Math.max(-89.9, Math.min(89.9, pose.elevation)));
    const direction = new THREE.Vector3(Math.cos(e) * Math.cos(a), Math.cos(e) * Math.sin(a), Math.sin(e));
    const half = THREE.MathUtils.degToRad(this.camera.fov / 2);
    const narrow = Math.min(half, Math.atan(Math.tan(half) * this.camera.aspect));
    const distance = pose.distance ?? this.bounds.radius / Math.sin(narrow);
    this.controls.target.copy(this.bounds.center);
    this.camera.position.copy(this.bounds.center).addScaledVector(direction, distance);
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
    this.invalidate();
  }

  invalidate(): void {
    this.dirty = true;
  }

  /** Draws if anything changed since the last call. */
  draw(force = false): boolean {
    this.controls.update();
    if (!this.dirty && !force) return false;
    this.dirty = false;
    this.renderer.render(this.scene, this.camera);
    return true;
  }
}
