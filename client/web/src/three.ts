// The module of the npm package for scenes of three.js.
export { PointreelObject } from "./three/object";
