// What the player uses of WebXR, which TypeScript's DOM library does not have.
type XRSessionMode = "immersive-vr" | "immersive-ar";

interface XRRigidTransform {
  readonly position: DOMPointReadOnly;
  readonly matrix: Float32Array;
}
interface XRView {
  readonly projectionMatrix: Float32Array;
  readonly transform: XRRigidTransform;
}
interface XRViewerPose {
  readonly transform: XRRigidTransform;
  readonly views: readonly XRView[];
}
interface XRReferenceSpace extends EventTarget {}
interface XRFrame {
  getViewerPose(space: XRReferenceSpace): XRViewerPose | null | undefined;
}
interface XRViewport {
  readonly x: number;
  readonly y: number;
  readonly width: number;
  readonly height: number;
}
interface XRInputSource {
  readonly gamepad?: Gamepad | null;
}
interface XRSession extends EventTarget {
  readonly renderState: { readonly baseLayer?: XRWebGLLayer | null };
  readonly inputSources: Iterable<XRInputSource>;
  updateRenderState(state: { baseLayer?: XRWebGLLayer; depthNear?: number }): void | Promise<void>;
  requestReferenceSpace(type: "local-floor"): Promise<XRReferenceSpace>;
  requestAnimationFrame(callback: (time: number, frame: XRFrame) => void): number;
  end(): Promise<void>;
}
interface XRSystem extends EventTarget {
  isSessionSupported(mode: XRSessionMode): Promise<boolean>;
  requestSession(mode: XRSessionMode, options: { requiredFeatures: string[] }): Promise<XRSession>;
}
interface XRWebGLLayer {
  readonly framebuffer: WebGLFramebuffer | null;
  getViewport(view: XRView): XRViewport | undefined;
}
declare var XRWebGLLayer: {
  new (session: XRSession, context: WebGL2RenderingContext, options?: { depth?: boolean; antialias?: boolean }): XRWebGLLayer;
};
interface Navigator {
  readonly xr?: XRSystem;
}
interface WebGL2RenderingContext {
  makeXRCompatible(): Promise<void>;
}
