import { StrictMode, useRef, useState } from "react";
import { createRoot } from "react-dom/client";
import { Annotation, MobileGS } from "mobilegs/react";

function App() {
  const scene = useRef(null);
  const [turning, setTurning] = useState(false);
  const [camera, setCamera] = useState("");
  const [state, setState] = useState("loading");
  const home = () => scene.current.act("reset");
  return (
    <main>
      <MobileGS
        ref={scene}
        src="scene.mgs"
        autorotate={turning}
        style={{ height: "60vh" }}
        onLoad={({ milliseconds }) => setState(`loaded in ${Math.round(milliseconds)} ms`)}
        onError={({ sentence }) => setState(sentence)}
        onCamera={(change) => setCamera(change.camera)}
      >
        <Annotation at={[0, 0, 0]} className="note">
          <strong>The middle</strong>
        </Annotation>
      </MobileGS>
      <p id="state">{state}</p>
      <p>{camera}</p>
      <button onClick={() => setTurning(!turning)}>{turning ? "Stop" : "Turn"}</button>
      <button onClick={home}>Back to the first view</button>
    </main>
  );
}

createRoot(document.querySelector("#root")).render(
  <StrictMode>
    <App />
  </StrictMode>,
);
