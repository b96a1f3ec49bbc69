// The body of a function: makes a renderer of three.js, and `three`, which tests use.
const map = document.createElement("script");
map.type = "importmap";
map.textContent = JSON.stringify({ imports: map_ });
document.head.append(map);
const THREE = await import(kind === "webgpu" ? "three/webgpu" : "three");
const { MobileGSMesh } = await import("/src/three/index.js");
const Renderer = kind === "webgpu" ? THREE.WebGPURenderer : THREE.WebGLRenderer;
const renderer = new Renderer(options);
await renderer.init?.();
if (kind === "webgpu" && !renderer.backend.isWebGPUBackend) throw new Error("there is no WebGPU here");
const scene = new THREE.Scene();
const camera = new THREE.PerspectiveCamera();
camera.matrixAutoUpdate = camera.matrixWorldAutoUpdate = false;
/** Take a camera of mobilegs. */
function look({ viewmat, fx, fy, cx, cy, width, height }, near = 0.1, far = 100) {
  renderer.setSize(width, height);
  const world = new THREE.Matrix4().set(...viewmat).invert().multiply(new THREE.Matrix4().makeScale(1, -1, -1));
  camera.matrix.copy(world);
  camera.matrixWorld.copy(world);
  camera.matrixWorldInverse.copy(world).invert();
  [camera.near, camera.far, camera.coordinateSystem] = [near, far, renderer.coordinateSystem];
  // otherwise the first frame replaces the projection
  camera._reversedDepth = renderer.reversedDepthBuffer ?? renderer.capabilities?.reversedDepthBuffer;
  const [left, right] = [-cx / fx, (width - cx) / fx].map((x) => x * near);
  const [top, bottom] = [cy / fy, (cy - height) / fy].map((y) => y * near);
  camera.projectionMatrix.makePerspective(left, right, top, bottom, near, far, renderer.coordinateSystem, camera.reversedDepth);
  camera.projectionMatrixInverse.copy(camera.projectionMatrix).invert();
}
/** The canvas as RGBA bytes, after drawing. */
function picture(render = () => renderer.render(scene, camera)) {
  render();
  const { width, height } = renderer.domElement;
  const copy = new OffscreenCanvas(width, height).getContext("2d", { colorSpace: "srgb" });
  copy.drawImage(renderer.domElement, 0, 0);
  return new Uint8Array(copy.getImageData(0, 0, width, height).data.buffer);
}
async function load(url, more = {}) {
  const mesh = new MobileGSMesh({ url });
  Object.assign(mesh, { variant: { floats: false, strips: false }, supersampling: 1 }, more);
  scene.add(mesh);
  await mesh.loaded;
  return mesh;
}
window.three = { THREE, MobileGSMesh, renderer, scene, camera, look, picture, load };
