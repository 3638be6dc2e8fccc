/**
 * The light of a photographer's studio as an environment map: a pale room, a large softbox above, a strip light on
 * one side, a warm floor. Painted on few pixels, since only its blurred forms are ever seen; z is up.
 */
import * as THREE from 'three';

const kWidth = 64;
const kHeight = 32;

/** Brightness (red, green, blue) that arrives from a direction. */
function radiance(x: number, y: number, z: number): [number, number, number] {
  const soft = (d: number, from: number, to: number) => THREE.MathUtils.smoothstep(d, from, to);
  const sky = 0.35 + 0.45 * soft(z, -0.2, 0.9);
  const floor = soft(-z, 0, 0.5);
  const softbox = 7 * soft(0.3 * x - 0.35 * y + 0.89 * z, 0.8, 0.92);
  const strip = 3.2 * soft(-0.85 * x - 0.45 * y + 0.28 * z, 0.86, 0.95);
  const rim = 2.2 * soft(0.4 * x + 0.86 * y + 0.32 * z, 0.9, 0.96);
  return [
    sky * 0.94 + floor * 0.3 + softbox + strip * 0.9 + rim,
    sky * 0.98 + floor * 0.28 + softbox * 0.98 + strip * 0.97 + rim,
    sky * 1.06 + floor * 0.26 + softbox * 0.94 + strip * 1.08 + rim,
  ];
}

export function studioLight(renderer: THREE.WebGLRenderer): THREE.Texture {
  const data = new Uint16Array(kWidth * kHeight * 4);
  for (let j = 0; j < kHeight; ++j)
    for (let i = 0; i < kWidth; ++i) {
      // The direction that three.js looks up at this pixel, with its y turned into our z.
      const latitude = ((j + 0.5) / kHeight - 0.5) * Math.PI;
      const longitude = ((i + 0.5) / kWidth - 0.5) * 2 * Math.PI;
      const flat = Math.cos(latitude);
      const rgb = radiance(flat * Math.cos(longitude), -flat * Math.sin(longitude), Math.sin(latitude));
      rgb.forEach((v, k) => (data[4 * (j * kWidth + i) + k] = THREE.DataUtils.toHalfFloat(v)));
      data[4 * (j * kWidth + i) + 3] = THREE.DataUtils.toHalfFloat(1);
    }
  const map = new THREE.DataTexture(data, kWidth, kHeight, THREE.RGBAFormat, THREE.HalfFloatType);
  map.mapping = THREE.EquirectangularReflectionMapping;
  map.minFilter = map.magFilter = THREE.LinearFilter;
  map.needsUpdate = true;
  const generator = new THREE.PMREMGenerator(renderer);
  const environment = generator.fromEquirectangular(map).texture;
  map.dispose();
  return environment;
}
