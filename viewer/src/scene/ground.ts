/** An endless studio floor under the bodies, soft shadows and a grid that fades; without obstacles, a mere grid at z = 0. */
import * as THREE from 'three';

const gridVertex = `
  varying vec2 at;
  void main() {
    vec4 world = modelMatrix * vec4(position, 1.0);
    at = world.xy;
    gl_Position = projectionMatrix * viewMatrix * world;
  }`;

// Lines are as wide as a pixel at any distance: the distance to the next line is measured in its own screen derivative.
const gridFragment = `
  uniform float spacing, reach, strength;
  uniform vec2 middle;
  uniform vec3 ink;
  varying vec2 at;
  float lines(vec2 p, float width) {
    vec2 d = fwidth(p);
    vec2 away = abs(fract(p - 0.5) - 0.5) / max(d, vec2(1e-6));
    vec2 on = 1.0 - smoothstep(0.0, width, away);
    on *= 1.0 - smoothstep(0.2, 0.5, d);
    return max(on.x, on.y);
  }
  void main() {
    float fade = 1.0 - smoothstep(0.15, 1.0, length(at - middle) / reach);
    float a = strength * max(0.16 * lines(at / spacing, 1.2), 0.30 * lines(at / (5.0 * spacing), 1.5));
    gl_FragColor = vec4(ink, a * fade);
  }`;

/** A round length, 1, 2 or 5 times a power of ten, near x. */
export function roundLength(x: number): number {
  const power = 10 ** Math.floor(Math.log10(x));
  const m = x / power;
  return power * (m < 1.5 ? 1 : m < 3.5 ? 2 : m < 7.5 ? 5 : 10);
}

export class Ground {
  readonly object = new THREE.Group();
  spacing = 0.1; // [m] between thin lines
  /** The scene has something to lie on. Where it has not, a floor under the bodies would lie about what they do. */
  standing = true;
  private readonly shadow: THREE.Mesh;
  private readonly grid: THREE.Mesh<THREE.PlaneGeometry, THREE.ShaderMaterial>;

  constructor() {
    const plane = new THREE.PlaneGeometry(2, 2);
    const dark = new THREE.ShadowMaterial({ opacity: 0.36, color: '#1c2733', depthWrite: false });
    this.shadow = new THREE.Mesh(plane, dark);
    this.shadow.receiveShadow = true;
    this.shadow.renderOrder = -2;
    this.grid = new THREE.Mesh(
      plane,
      new THREE.ShaderMaterial({
        vertexShader: gridVertex,
        fragmentShader: gridFragment,
        transparent: true,
        depthWrite: false,
        side: THREE.DoubleSide,
        uniforms: {
          spacing: { value: 0.1 },
          reach: { value: 1 },
          strength: { value: 1 },
          middle: { value: new THREE.Vector2() },
          ink: { value: new THREE.Color('#24384d') },
        },
      }),
    );
    this.grid.renderOrder = -1;
    this.object.add(this.shadow, this.grid);
  }

  /** With a floor of the scene's own, shadows and grid lie just above it. */
  setFloor(height: number | undefined, radius: number): void {
    this.grid.material.uniforms.strength!.value = height !== undefined ? 0.6 : this.standing ? 1 : 0.35;
    if (height !== undefined) this.object.position.z = height + 0.0005 * radius;
  }

  /** Lies at the bottom of the box that holds what is to be seen; without obstacles at z = 0, if all stays above it. */
  place(center: THREE.Vector3, radius: number, box: THREE.Box3): void {
    const reach = 5 * radius;
    this.spacing = roundLength(radius / 6);
    this.object.position.set(center.x, center.y, this.standing ? box.min.z - 0.002 * radius : 0);
    this.object.visible = this.standing || (box.min.z > -0.05 * radius && box.min.z < radius);
    this.shadow.visible = this.standing;
    this.object.scale.set(reach, reach, 1);
    const u = this.grid.material.uniforms;
    u.spacing!.value = this.spacing;
    u.reach!.value = reach;
    (u.middle!.value as THREE.Vector2).set(center.x, center.y);
  }
}
