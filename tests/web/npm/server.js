/** Prints what a server of React renders: every entry of the package can be imported without a page. */

import { createElement } from "react";
import { renderToString } from "react-dom/server";

import "mobilegs";
import "mobilegs/element";
import "mobilegs/three";
import { Annotation, MobileGS } from "mobilegs/react";

// react-three-fiber 9 needs React 19
if (process.argv[2] === "19") await import("mobilegs/react-three");
const properties = {
  src: "scene.mgs",
  autorotate: true,
  noui: false,
  lazy: true,
  startPortrait: "0 0 1 0 0 0 1 1",
  fov: 40,
  className: "stage",
  style: { height: "300px" },
  annotations: [{ at: [0, 1, 0], text: "a \"door\"" }],
  onCamera: () => {},
};
const note = createElement(Annotation, { at: [1, 2.5, -3], className: "note" }, "here");
console.log(renderToString(createElement(MobileGS, properties, note)));
