/**
 * The viewer of antimatter15/splat. It is a page of its own rather than a library: its script finds
 * elements by their names, reads the scene's address from the page's, and draws in a loop of its own.
 */

/** The loop's next frame, which it asks for at the end of each. @type {FrameRequestCallback | null} */
let frame = null;

/** Its matrix lies column by column. @param {import("./drive.js").Camera} camera */
const columns = ({ viewmat }) => Array.from({ length: 16 }, (_, i) => viewmat[4 * (i % 4) + (i >> 2)]);

export async function open({ stage, scene, camera }) {
  for (const id of ["fps", "camid", "spinner", "progress", "message"]) {
    stage.append(Object.assign(document.createElement("div"), { id, hidden: true }));
  }
  const canvas = Object.assign(document.createElement("canvas"), { id: "canvas" });
  stage.append(canvas);
  const [url, start] = [new URL(scene, location.href), JSON.stringify(columns(camera))];
  history.replaceState(null, "", `?url=${url}#${start}`);
  const asked = window.requestAnimationFrame.bind(window);
  window.requestAnimationFrame = (next) => {
    frame = next;
    return 0;
  };
  const script = Object.assign(document.createElement("script"), { src: "/antimatter15/main.js" });
  await new Promise((resolve, reject) => {
    script.onload = resolve;
    script.onerror = () => reject(new Error("there is no main.js of antimatter15/splat"));
    document.head.append(script);
  });
  // names that the script declared belong to scripts, and are none of the window's
  const { look, zoom } = (0, eval)("({ look: (to) => (viewMatrix = to), zoom: (of) => (camera = of) })");
  zoom({ fx: camera.fx, fy: camera.fy });
  const draw = (next) =>
    new Promise((resolve) => {
      asked((now) => {
        const began = performance.now();
        look(columns(next));
        frame?.(now);
        resolve(began);
      });
    });
  const [spinner, message] = ["spinner", "message"].map((id) => document.getElementById(id));
  // it hides that with the first frame that has Gaussians
  while (spinner.style.display !== "none") await draw(camera);
  if (message.innerText) throw new Error(message.innerText);
  return { canvas, draw };
}
