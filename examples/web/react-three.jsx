import { StrictMode, useState } from "react";
import { createRoot } from "react-dom/client";
import { Canvas, useThree } from "@react-three/fiber";
import { Matrix4 } from "three";
import { MobileGSObject } from "mobilegs/react-three";

function Scene() {
  const camera = useThree((state) => state.camera);
  const [ring, setRing] = useState(null);
  // begin where a photo was taken; its y axis points down and its z axis ahead
  const begin = ({ views: [{ viewmat }] }) => {
    const place = new Matrix4().set(...viewmat).invert().multiply(new Matrix4().makeScale(1, -1, -1));
    place.decompose(camera.position, camera.quaternion, camera.scale);
  };
  return (
    <>
      <MobileGSObject url="scene.mgs" onLoad={begin} onClick={({ point, distance }) => setRing({ point, distance })} />
      {ring && (
        <mesh position={ring.point} scale={0.2 * ring.distance}>
          <torusGeometry args={[1, 0.1]} />
          <meshNormalMaterial />
        </mesh>
      )}
    </>
  );
}

createRoot(document.querySelector("#root")).render(
  <StrictMode>
    <Canvas frameloop="demand" camera={{ fov: 60 }}>
      <Scene />
    </Canvas>
  </StrictMode>,
);
