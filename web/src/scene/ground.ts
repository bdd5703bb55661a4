// The ground below everything: a grid that fades, and a soft shadow of what stands over it.

import {
  BufferAttribute, BufferGeometry, Color, LineBasicMaterial, LineSegments, Mesh, MeshBasicMaterial, NoBlending, OrthographicCamera,
  PlaneGeometry, ShaderMaterial, WebGLRenderTarget, type Scene, type WebGLRenderer,
} from "three";

const CELLS = 16;
/** Pixels of a shadow's side: it is soft, so few are enough. */
const PIXELS = 128;
const DARK = 0.34;

/** A square grid of one unit, fading from its middle on. */
function squares(): LineSegments<BufferGeometry, LineBasicMaterial> {
  const [points, shades]: [number[], number[]] = [[], []];
  const put = (x: number, y: number): void => {
    points.push(x, y, 0);
    shades.push(1, 1, 1, Math.max(1 - Math.hypot(x, y) / CELLS, 0) ** 1.5);
  };
  for (let k = -CELLS; k <= CELLS; k++) {
    for (let i = -CELLS; i < CELLS; i += 2) {
      put(i, k), put(i + 2, k);
      put(k, i), put(k, i + 2);
    }
  }
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(new Float32Array(points), 3));
  geometry.setAttribute("color", new BufferAttribute(new Float32Array(shades), 4));
  return new LineSegments(geometry, new LineBasicMaterial({ vertexColors: true, transparent: true, depthWrite: false }));
}

const VERTEX = "varying vec2 at; void main() { at = uv; gl_Position = vec4(2.0 * position.xy, 0.0, 1.0); }";
/** Looks around, in three circles: the target is small, and its own smoothing does the rest. */
const FRAGMENT = `
varying vec2 at; uniform sampler2D seen;
void main() {
  float sum = texture2D(seen, at).a;
  for (int k = 0; k < 18; k++) {
    float angle = 1.0472 * float(k) + float(k / 6);
    sum += texture2D(seen, at + 0.012 * float(1 + k / 6) * vec2(cos(angle), sin(angle))).a;
  }
  float edge = smoothstep(0.5, 0.36, max(abs(at.x - 0.5), abs(at.y - 0.5)));
  gl_FragColor = vec4(0.0, 0.0, 0.0, edge * sum / 19.0);
}`;

export class Ground {
  readonly grid = squares();
  private readonly target = new WebGLRenderTarget(PIXELS, PIXELS, { depthBuffer: false });
  private readonly above = new OrthographicCamera();
  private readonly black = new MeshBasicMaterial({ color: 0 });
  private readonly soft = new WebGLRenderTarget(PIXELS, PIXELS, { depthBuffer: false });
  private readonly shadow: Mesh<PlaneGeometry, MeshBasicMaterial>;
  /** What makes it soft: once for its few pixels, not for all of the picture's. */
  private readonly blur: Mesh<PlaneGeometry, ShaderMaterial>;

  constructor() {
    const plane = new PlaneGeometry(1, 1);
    const uniforms = { seen: { value: this.target.texture } };
    this.blur = new Mesh(plane, new ShaderMaterial({ uniforms, vertexShader: VERTEX, fragmentShader: FRAGMENT, blending: NoBlending, depthTest: false }));
    this.blur.frustumCulled = false;
    this.shadow = new Mesh(plane, new MeshBasicMaterial({ map: this.soft.texture, transparent: true, depthWrite: false }));
    this.shadow.renderOrder = -1;
    this.grid.renderOrder = -2;
  }

  get parts(): [Mesh, LineSegments] {
    return [this.shadow, this.grid];
  }

  /** Below a box [m], with squares of a size [m]. */
  put(low: number[], high: number[], floor: number, step: number): void {
    const [x = 0, y = 0] = [0, 1].map((k) => 0.5 * ((low[k] ?? 0) + (high[k] ?? 0)));
    const [wide = 1, deep = 1] = [0, 1].map((k) => 1.5 * ((high[k] ?? 0) - (low[k] ?? 0)) + 4 * step);
    this.grid.position.set(step * Math.round(x / step), step * Math.round(y / step), floor);
    this.grid.scale.setScalar(step);
    this.shadow.position.set(x, y, floor + 1e-4 * wide);
    this.shadow.scale.set(wide, deep, 1);
    Object.assign(this.above, { left: -0.5 * wide, right: 0.5 * wide, top: 0.5 * deep, bottom: -0.5 * deep, near: 0, far: 100 * wide });
    this.above.position.set(x, y, floor + 50 * wide);
    this.above.updateProjectionMatrix();
  }

  /** Draw what is seen from above, all in black; what is to cast no shadow must be hidden. */
  cast(renderer: WebGLRenderer, world: Scene): void {
    const [shown, background] = [this.parts.map((one) => one.visible), new Color()];
    const alpha = renderer.getClearAlpha();
    renderer.getClearColor(background);
    this.parts.forEach((one) => (one.visible = false));
    world.overrideMaterial = this.black;
    renderer.setRenderTarget(this.target);
    renderer.setClearColor(0, 0);
    renderer.clear();
    renderer.render(world, this.above);
    world.overrideMaterial = null;
    renderer.setRenderTarget(this.soft);
    renderer.render(this.blur, this.above);
    renderer.setRenderTarget(null);
    renderer.setClearColor(background, alpha);
    this.parts.forEach((one, k) => (one.visible = shown[k] ?? true));
  }

  paint(line: string, dark: boolean): void {
    this.grid.material.color.set(line);
    this.shadow.material.opacity = dark ? 0.75 : DARK;
  }

  dispose(): void {
    this.grid.geometry.dispose();
    this.grid.material.dispose();
    this.shadow.geometry.dispose();
    this.shadow.material.dispose();
    this.blur.material.dispose();
    this.soft.dispose();
    this.black.dispose();
    this.target.dispose();
  }
}
