export type MobileGsText =
  | "src"
  | "poster"
  | "compare"
  | "background"
  | "fov"
  | "up"
  | "start"
  | "startPortrait"
  | "limits"
  | "annotations"
  | "path"
  | "follow"
  | "heading"
  | "credit"
  | "alt"
  | "renderer"
  | "scale"
  | "levels"
  | "variant"
  | "loading";
export type MobileGsSwitch = "autorotate" | "autoplay" | "noui" | "polite" | "free";
/** Events of `<mobile-gs>`; all are CustomEvents. */
export interface MobileGsEventMap {
  /** The whole scene is decoded. */
  load: CustomEvent<{ milliseconds: number; bytes: number }>;
  /** The scene cannot be shown; the sentence says why. */
  error: CustomEvent<{ sentence: string }>;
  /** A frame was drawn, which happens only when something changes. */
  frame: CustomEvent<import("./viewer/stats.js").Stats>;
  /** The camera has moved. */
  camera: CustomEvent<CameraChange>;
}
/** Attributes as properties: an empty text, or false, without the attribute; null removes it. */
export interface MobileGs extends Record<MobileGsText, string>, Record<MobileGsSwitch, boolean> {
  addEventListener<K extends keyof MobileGsEventMap>(type: K, listener: (this: MobileGs, event: MobileGsEventMap[K]) => void, options?: boolean | AddEventListenerOptions): void;
  addEventListener<K extends Exclude<keyof HTMLElementEventMap, keyof MobileGsEventMap>>(type: K, listener: (this: MobileGs, event: HTMLElementEventMap[K]) => void, options?: boolean | AddEventListenerOptions): void;
  addEventListener(type: string, listener: EventListenerOrEventListenerObject, options?: boolean | AddEventListenerOptions): void;
  removeEventListener<K extends keyof MobileGsEventMap>(type: K, listener: (this: MobileGs, event: MobileGsEventMap[K]) => void, options?: boolean | EventListenerOptions): void;
  removeEventListener(type: string, listener: EventListenerOrEventListenerObject, options?: boolean | EventListenerOptions): void;
}
declare global {
  interface HTMLElementTagNameMap {
    "mobile-gs": MobileGs;
  }
}
