// The body of a function: the viewer's picture of the scene of `mesh`, with the settings that the viewer chooses.
const Renderer = (await import(`/src/render/${kind.module}`))[kind.name];
const { parsed } = await import("/src/assets.js");
const shaders = await parsed(import(`/src/${kind.language}.packed.js`));
const own = await Renderer.create(document.createElement("canvas"), shaders);
const { usualLevelSigma } = await import("/src/render/levels.js");
const { supersamplingFor } = await import("/src/viewer/supersampling.js");
own.setScene({ ...mesh.data });
own.levelSigma = usualLevelSigma(mesh.data.footprint);
own.supersampling = supersamplingFor(view, mesh.views);
const pixels = await own.pixels(view);
own.destroy();
return Uint8Array.from(pixels, (value) => Math.round(255 * Math.min(Math.max(value, 0), 1)));
