/** A page whose HTML comes from a server: it is hydrated in strict mode, and changed by `window.change`. */

import { StrictMode, createElement, useState } from "react";
import { hydrateRoot } from "react-dom/client";
import { renderToString } from "react-dom/server";
import { Annotation, MobileGS } from "mobilegs/react";

window.told = [];

function App() {
  const [change, setChange] = useState({});
  const [there, setThere] = useState(true);
  window.change = setChange;
  window.leave = () => setThere(false);
  const note = createElement(Annotation, { at: [0, 0, 0], className: "note" }, "here");
  const tell = (kind) => (detail) => told.push({ kind, ...(kind === "camera" ? { camera: detail.camera } : {}) });
  const properties = {
    ref: (element) => void (window.element = element),
    src: "scene.mgs",
    renderer: "webgl",
    variant: "floats",
    className: "stage",
    style: { height: "300px" },
    onLoad: tell("load"),
    onCamera: tell("camera"),
    onError: tell("error"),
    ...change,
  };
  return there ? createElement(MobileGS, properties, note) : null;
}

const app = createElement(StrictMode, null, createElement(App));
const root = document.querySelector("#root");
root.innerHTML = renderToString(app);
hydrateRoot(root, app);
