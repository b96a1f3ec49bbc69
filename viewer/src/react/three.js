/**
 * Entry point `mobilegs/react-three`: a scene in react-three-fiber.
 *
 *     <Canvas>
 *       <MobileGSObject url="scene.mgs" rotation={[Math.PI, 0, 0]} />
 *     </Canvas>
 */

import { useThree } from "@react-three/fiber";
import { createElement, forwardRef, useEffect, useRef, useState } from "react";

import { MobileGSMesh } from "../three/index.js";

/** @typedef {"url" | "file" | "onProgress" | "onLoad" | "onError"} MeshOption */
/** @typedef {Pick<import("../three/mobile_gs_mesh.js").MobileGSMeshOptions, MeshOption>} OwnProps */
/** @typedef {Partial<Pick<MobileGSMesh, "opacity" | "grade" | "crop" | "supersampling" | "levelSigma">>} Look */
/** @typedef {OwnProps & Look & Omit<import("@react-three/fiber").ThreeElements["mesh"], MeshOption | "ref">} MobileGSObjectProps */

/**
 * A `MobileGSMesh` with the properties of a mesh. The ref is the mesh. Another `url` or `file` makes another mesh.
 * Without `onError`, an error boundary gets what goes wrong.
 *
 * @type {import("react").ForwardRefExoticComponent<MobileGSObjectProps & import("react").RefAttributes<MobileGSMesh>>}
 */
export const MobileGSObject = forwardRef(function MobileGSObject(/** @type {MobileGSObjectProps} */ props, ref) {
  const { url, file, onProgress, onLoad, onError, ...rest } = props;
  const [mesh, setMesh] = useState(/** @type {MobileGSMesh | null} */ (null));
  const [error, setError] = useState(/** @type {Error | null} */ (null));
  const invalidate = useThree((state) => state.invalidate);
  const latest = useRef(props);
  useEffect(() => {
    latest.current = props;
  });
  useEffect(() => {
    const made = new MobileGSMesh({
      url,
      file,
      onProgress: (share) => {
        latest.current.onProgress?.(share);
        invalidate(); // more of the scene may be there
      },
      onLoad: () => {
        latest.current.onLoad?.(made);
        invalidate();
      },
      onError: (reason) => (latest.current.onError ?? setError)(reason),
    });
    setMesh(made);
    return () => made.dispose();
  }, [url, file, invalidate]);
  if (error) throw error; // the nearest error boundary shows it
  return mesh && createElement("primitive", { ...rest, object: mesh, ref });
});
