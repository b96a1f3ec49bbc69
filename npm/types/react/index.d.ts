/** Attributes of `<mobile-gs>` in JSX, without the component. */
export type MobileGsAttributes = import("react").HTMLAttributes<MobileGs> &
  import("react").RefAttributes<MobileGs> & {
    src?: string;
    compare?: string;
    camera?: string;
    follow?: string;
    poster?: string;
    background?: string;
    renderer?: "auto" | "webgpu" | "webgl";
    loading?: "lazy";
    [attribute: string]: unknown;
  };
declare module "react" {
  namespace JSX {
    interface IntrinsicElements {
      "mobile-gs": MobileGsAttributes;
    }
  }
}
