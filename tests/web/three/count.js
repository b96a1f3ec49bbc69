// The body of a function: counts the objects of the GPU that a mesh makes, and those left after `dispose`.
const kept = new Set();
const watch = (owner, make, drop) => {
  const [made, dropped] = [owner[make], drop && owner[drop]];
  owner[make] = function (...given) {
    const found = made.apply(this, given);
    kept.add(found);
    return found;
  };
  if (drop) owner[drop] = function (one) { kept.delete(one); return dropped.call(this, one); };
};
const { renderer, scene, camera, look } = three;
look(view);
if (kind === "webgl") {
  const gl = renderer.getContext();
  for (const what of ["Texture", "Buffer", "Framebuffer", "Renderbuffer", "Program", "VertexArray"]) {
    watch(gl, `create${what}`, `delete${what}`);
  }
} else {
  const { device } = renderer.backend;
  for (const what of ["Texture", "Buffer"]) watch(device, `create${what}`);
  for (const type of [GPUTexture, GPUBuffer]) {
    const { destroy } = type.prototype;
    type.prototype.destroy = function () { kept.delete(this); return destroy.call(this); };
  }
}
renderer.render(scene, camera);
const before = new Set(kept);
const mesh = await three.load(url);
renderer.render(scene, camera);
const most = kept.size - before.size;
mesh.dispose();
renderer.render(scene, camera);
return [most, kept.size - before.size, scene.children.length];
