/** A plane through the scene that shows the densities of the grid, where they overlap, and the tiles that are awake. */
import * as THREE from 'three';
import { densityPixels, overlapPixels, overlapStops, rgbOf, tileOutlines, type Slice } from '../slice';

const vertex = `
  attribute vec2 node;
  varying vec2 at;
  void main() {
    at = node;
    gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
  }`;

// Colours are meant as the screen shows them; the tone mapping of the bodies is not for data.
const fragment = `
  uniform sampler2D fill, over;
  uniform vec2 nodes;
  uniform vec3 paper, ink, touch, middle, deep;
  varying vec2 at;
  // A line, some pixels wide, where a quantity passes a level.
  float level(float x, float here, float width) {
    return 1.0 - smoothstep(0.0, width, abs(x - here) / max(fwidth(x), 1e-5));
  }
  void main() {
    vec2 uv = (at + 0.5) / nodes;
    vec4 f = texture2D(fill, uv);
    float rho = f.a;
    float o = texture2D(over, uv).r;
    vec3 own = f.rgb / max(rho, 0.004);
    vec3 colour = mix(paper, own, smoothstep(0.0, 0.9, rho));
    float alpha = mix(0.42, 0.98, smoothstep(0.02, 0.25, rho));
    // The surface, where half of the space is filled, and two thin lines beside it that show how wide the ramp is.
    float thin = max(level(rho, 0.1, 1.0), level(rho, 0.9, 1.0));
    colour = mix(colour, ink, 0.16 * thin);
    colour = mix(colour, ink, 0.62 * level(rho, 0.5, 1.7));
    // Overlap.
    vec3 hot = o < 0.5 ? mix(touch, middle, 2.0 * o) : mix(middle, deep, 2.0 * o - 1.0);
    float hit = smoothstep(0.08, 0.5, o); // light touches glow, deep ones burn
    colour = mix(colour, hot, 0.92 * hit);
    // Nodes, once they are far enough apart to be told one from another.
    vec2 apart = 1.0 / max(fwidth(at), vec2(1e-6));
    float room = smoothstep(7.0, 16.0, min(apart.x, apart.y));
    float dot_ = 1.0 - smoothstep(0.8, 1.9, length((fract(at + 0.5) - 0.5) * apart));
    colour = mix(colour, ink, 0.32 * room * dot_);
    // The border of the plane.
    vec2 rim = min(at, nodes - 1.0 - at) * apart;
    float border = 1.0 - smoothstep(0.6, 1.8, min(rim.x, rim.y));
    colour = mix(colour, ink, 0.35 * border);
    gl_FragColor = vec4(colour, max(alpha, 0.6 * border));
  }`;

const srgb = (c: string) => {
  const [r, g, b] = rgbOf(c);
  return new THREE.Vector3(r / 255, g / 255, b / 255);
};

function texture(data: Uint8Array<ArrayBuffer>, count: [number, number], format: THREE.PixelFormat) {
  const t = new THREE.DataTexture(data, count[0], count[1], format, THREE.UnsignedByteType);
  t.magFilter = t.minFilter = THREE.LinearFilter;
  t.unpackAlignment = 1;
  t.needsUpdate = true;
  return t;
}

export class SliceView {
  readonly object = new THREE.Group();
  /** Hides what lies between the plane and the camera; the same object for good, so that materials may keep it. */
  readonly clip = new THREE.Plane();
  shown: Slice | undefined;
  private readonly plane: THREE.Mesh<THREE.BufferGeometry, THREE.ShaderMaterial>;
  private readonly tiles: THREE.LineSegments<THREE.BufferGeometry, THREE.LineBasicMaterial>;

  constructor() {
    const material = new THREE.ShaderMaterial({
      vertexShader: vertex,
      fragmentShader: fragment,
      transparent: true,
      depthWrite: false,
      side: THREE.DoubleSide,
      toneMapped: false,
      uniforms: {
        fill: { value: null },
        over: { value: null },
        nodes: { value: new THREE.Vector2() },
        paper: { value: srgb('#f7f4ee') },
        ink: { value: srgb('#16202c') },
        touch: { value: srgb(overlapStops[0]!) },
        middle: { value: srgb(overlapStops[1]!) },
        deep: { value: srgb(overlapStops[2]!) },
      },
    });
    this.plane = new THREE.Mesh(new THREE.BufferGeometry(), material);
    this.plane.frustumCulled = false;
    this.plane.renderOrder = 2;
    this.tiles = new THREE.LineSegments(
      new THREE.BufferGeometry(),
      new THREE.LineBasicMaterial({ color: '#1c6f8f', transparent: true, opacity: 0.75, toneMapped: false }),
    );
    this.tiles.frustumCulled = false;
    this.tiles.renderOrder = 3;
    this.object.add(this.plane, this.tiles);
    this.object.visible = false;
  }

  update(
    slice: Slice,
    colours: string[],
    single: boolean,
    tiles: { key: Int32Array; step: Float32Array },
  ): void {
    this.shown = slice;
    const u = (slice.axis + 1) % 3;
    const v = (slice.axis + 2) % 3;
    const positions = new Float32Array(12);
    const nodes = new Float32Array(8);
    [
      [0, 0],
      [1, 0],
      [1, 1],
      [0, 1],
    ].forEach(([a, b], i) => {
      nodes[2 * i] = a! * (slice.count[0] - 1);
      nodes[2 * i + 1] = b! * (slice.count[1] - 1);
      positions[3 * i + slice.axis] = slice.at;
      positions[3 * i + u] = slice.step * (slice.first[0] + nodes[2 * i]!);
      positions[3 * i + v] = slice.step * (slice.first[1] + nodes[2 * i + 1]!);
    });
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(positions, 3));
    geometry.setAttribute('node', new THREE.BufferAttribute(nodes, 2));
    geometry.setIndex([0, 1, 2, 0, 2, 3]);
    this.plane.geometry.dispose();
    this.plane.geometry = geometry;
    const uniforms = this.plane.material.uniforms;
    (uniforms.fill!.value as THREE.Texture | null)?.dispose();
    (uniforms.over!.value as THREE.Texture | null)?.dispose();
    uniforms.fill!.value = texture(densityPixels(slice, colours, single), slice.count, THREE.RGBAFormat);
    uniforms.over!.value = texture(overlapPixels(slice), slice.count, THREE.RedFormat);
    (uniforms.nodes!.value as THREE.Vector2).set(slice.count[0], slice.count[1]);
    const outline = new THREE.BufferGeometry();
    outline.setAttribute('position', new THREE.BufferAttribute(tileOutlines(slice, tiles).positions, 3));
    this.tiles.geometry.dispose();
    this.tiles.geometry = outline;
  }

  /** Turns the clipping plane so that it hides the camera's side. */
  face(camera: THREE.Vector3): void {
    if (!this.shown) return;
    const { axis, at } = this.shown;
    const side = camera.getComponent(axis) >= at ? 1 : -1;
    this.clip.normal.set(0, 0, 0).setComponent(axis, -side);
    this.clip.constant = side * at;
  }
}
