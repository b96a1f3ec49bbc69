/** A project in strict mode: compiles if the types of the package are right. */

import { decodeMgs, SceneError, type MgsScene } from "mobilegs";
import type { CameraChange, MobileGs } from "mobilegs/element";
import { Annotation, MobileGS } from "mobilegs/react";
import { MobileGSObject } from "mobilegs/react-three";
import { MobileGSMesh, type FirstView, type MobileGSMeshOptions } from "mobilegs/three";
import { useRef } from "react";

export async function decoded(file: File): Promise<Float32Array> {
  const options = { signal: AbortSignal.timeout(1000), onProgress: ({ received }: { received: number }) => received };
  const scene: MgsScene = await decodeMgs(file, options);
  const lobes: Float32Array | null = scene.lobes;
  // @ts-expect-error there may be none
  scene.lobes.length;
  // @ts-expect-error not a source
  await decodeMgs(3).catch((error) => error instanceof SceneError);
  return lobes ?? scene.means;
}

export async function shown(): Promise<boolean> {
  const made = document.createElement("mobile-gs");
  const found: MobileGs | null = document.querySelector("mobile-gs");
  made.camera = found?.camera ?? "";
  made.src = "scene.mgs";
  made.noui = true;
  made.addEventListener("camera", ({ detail }) => detail.origin.camera satisfies string);
  made.addEventListener("error", ({ detail }) => detail.sentence satisfies string);
  made.addEventListener("click", (event) => event.clientX satisfies number);
  const point: [number, number, number] | null = made.pointAt(1, 2);
  // @ts-expect-error not a camera
  void made.flyTo(3);
  // @ts-expect-error internal
  void made.viewer;
  return made.flyTo({ eye: [0, 0, 1], target: point ?? [0, 0, 0] }, { seconds: 2, signal: AbortSignal.timeout(9) });
}

export function placed(): MobileGSMesh {
  const options: MobileGSMeshOptions = { url: new URL("https://example.org/scene.mgs"), signal: AbortSignal.timeout(9) };
  const mesh = new MobileGSMesh({ ...options, onLoad: (loaded) => loaded.position.set(0, 1, 0) });
  mesh.opacity = 0.5;
  const { position, fov }: FirstView = mesh.firstView(1.5);
  mesh.crop?.containsPoint(position);
  // @ts-expect-error internal
  void mesh.data;
  const other: MobileGSMesh = mesh.clone();
  other.scale.setScalar(fov);
  return mesh;
}

export function App() {
  const ref = useRef<MobileGs>(null);
  const moved = ({ camera, eye }: CameraChange) => `${camera} ${eye[0]}`;
  return (
    <main onClick={() => void ref.current?.flyTo("eye=0,0,1&at=0,0,0&up=0,1,0")}>
      <MobileGS ref={ref} src="scene.mgs" autorotate className="scene" style={{ height: 300 }} onCamera={moved}>
        <Annotation at={[0, 1, 0]} title="door">
          The door
        </Annotation>
      </MobileGS>
      <mobile-gs src="scene.mgs" autorotate="" className="scene" />
      <MobileGSObject url="scene.mgs" rotation={[Math.PI, 0, 0]} opacity={0.5} onLoad={(mesh) => mesh.position.x} />
      {/* @ts-expect-error an address is a text */}
      <MobileGS src={3} />
      {/* @ts-expect-error it has a point */}
      <Annotation>nowhere</Annotation>
    </main>
  );
}
