/** A page whose error boundary shows why a scene of react-three-fiber cannot be loaded. */

import { Component, createElement } from "react";
import { createRoot } from "react-dom/client";
import { Canvas } from "@react-three/fiber";
import { MobileGSObject } from "mobilegs/react-three";

class Boundary extends Component {
  state = { error: null };

  static getDerivedStateFromError(error) {
    return { error };
  }

  render() {
    const { error } = this.state;
    return error ? createElement("p", { id: "told" }, error.message) : this.props.children;
  }
}

const scene = createElement(MobileGSObject, { url: "missing.mgs" });
const app = createElement(Boundary, null, createElement(Canvas, null, scene));
createRoot(document.querySelector("#root"), { onCaughtError: () => {} }).render(app);
