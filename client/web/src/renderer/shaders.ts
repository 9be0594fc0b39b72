// The texts of all programs. Most are those of the desktop player, written for OpenGL 4.5.
import back from "../../../render/opengl/shaders/back.vert.glsl";
import common from "../../../render/opengl/shaders/common.glsl";
import discDepth from "../../../render/opengl/shaders/disc_depth.frag.glsl";
import discSum from "../../../render/opengl/shaders/disc_sum.frag.glsl";
import flat from "../../../render/opengl/shaders/flat.frag.glsl";
import floorFragment from "../../../render/opengl/shaders/floor.frag.glsl";
import floorShadow from "../../../render/opengl/shaders/floor_shadow.frag.glsl";
import floorVertex from "../../../render/opengl/shaders/floor.vert.glsl";
import light from "../../../render/opengl/shaders/light.frag.glsl";
import mean from "../../../render/opengl/shaders/mean.glsl";
import nothing from "../../../render/opengl/shaders/nothing.frag.glsl";
import open from "../../../render/opengl/shaders/open.frag.glsl";
import outlines from "../../../render/opengl/shaders/outlines.frag.glsl";
import pointFragment from "../../../render/opengl/shaders/point.frag.glsl";
import point from "../../../render/opengl/shaders/point.vert.glsl";
import pull from "../../../render/opengl/shaders/pull.frag.glsl";
import pullSums from "../../../render/opengl/shaders/pull_sums.frag.glsl";
import push from "../../../render/opengl/shaders/push.frag.glsl";
import quadFootprint from "../../../render/opengl/shaders/quad_footprint.glsl";
import resolve from "../../../render/opengl/shaders/resolve.frag.glsl";
import seeThrough from "../../../render/opengl/shaders/see_through.frag.glsl";
import shading from "../../../render/opengl/shaders/shading.glsl";
import shadow from "../../../render/opengl/shaders/shadow.vert.glsl";
import shadowBlur from "../../../render/opengl/shaders/shadow_blur.frag.glsl";
import stripFragment from "../../../render/opengl/shaders/strip.frag.glsl";
import stripVertex from "../../../render/opengl/shaders/strip.vert.glsl";
import whole from "../../../render/opengl/shaders/whole_picture.vert.glsl";
import mark from "../../../render/opengl/instancing/pull/mark.glsl";
import spriteFootprint from "../../../render/opengl/instancing/pull/sprite_footprint.glsl";
import surfelMark from "../../../render/opengl/instancing/pull/surfel_mark.glsl";
import surfelSprite from "../../../render/opengl/instancing/pull/surfel_sprite.glsl";
import surfelSpriteVertex from "../../../render/opengl/instancing/pull/surfel_sprite.vert.glsl";
import voxelMark from "../../../render/opengl/instancing/pull/voxel_mark.glsl";
import voxelSprite from "../../../render/opengl/instancing/pull/voxel_sprite.glsl";
import voxelSpriteFragment from "../../../render/opengl/instancing/pull/voxel_sprite.frag.glsl";
import voxelSpriteVertex from "../../../render/opengl/instancing/pull/voxel_sprite.vert.glsl";
import instance from "../../../render/opengl/instancing/shaders/instance.glsl";
import separateTriangles from "../../../render/opengl/instancing/shaders/separate_triangles.glsl";
import surfel from "../../../render/opengl/instancing/shaders/surfel.glsl";
import surfelVertex from "../../../render/opengl/instancing/shaders/surfel_vertex.glsl";
import voxel from "../../../render/opengl/instancing/shaders/voxel.glsl";
import voxelFaces from "../../../render/opengl/instancing/shaders/voxel_faces.glsl";
import depthBits from "./shaders/depth_bits.frag.glsl";
import fetch from "./shaders/fetch.glsl";
import present from "./shaders/present.frag.glsl";
import solid from "./shaders/solid.vert.glsl";
import sprite from "./shaders/sprite.vert.glsl";
import sprites from "./shaders/sprites.glsl";
import srgb from "./shaders/srgb.glsl";
import { LateProgram, Texts } from "./gl";

const HEADER = `#version 300 es
precision highp float;
precision highp int;
precision highp sampler2D;
precision highp usampler2D;
`;

/** What OpenGL ES 3.0 says differently. */
function es(text: string): string {
  return text
    .replace(/layout\(std140, binding = \d+\) uniform/g, "layout(std140) uniform")
    .replace(/layout\((?:binding|location) = \d+\) uniform/g, "uniform")
    .replace("noperspective out float side;", "out float side_by_w;\nfloat side;")
    .replace("noperspective in float side;",
             "in float side_by_w;\n#define side (side_by_w * gl_FragCoord.w)");
}

function unitsOf(texts: string[]): Map<string, number> {
  const units = new Map<string, number>();
  for (const text of texts)
    for (const [, unit, name] of text.matchAll(/layout\(binding = (\d+)\) uniform \w+ (\w+);/g))
      units.set(name!, Number(unit));
  return units;
}

/** `main` of a text under another name, for a `main` that calls it. */
const renamed = (text: string, name: string) => text.replace("void main()", `void ${name}()`);

interface Parts {
  vertex: string[];
  fragment: string[];
  afterVertex?: string;
  afterFragment?: string;
}

/**
 * With the extension EXT_clip_control, depths in clip coordinates go from 0 to w as on the desktop.
 * Without it they go from -w to w, and each vertex is moved there.
 */
export function makePrograms(gl: WebGL2RenderingContext, hasClipControl: boolean) {
  const toClip = hasClipControl ? "" : "gl_Position.z = 2.0 * gl_Position.z - gl_Position.w;";
  const stage = (texts: string[], after: string): string => {
    const [last, ...others] = [...texts].reverse();
    const all = after ? [...others.reverse(), renamed(last!, "inner_main"),
                         `void main() {\n  inner_main();\n  ${after}\n}\n`]
                      : texts;
    return HEADER + es([common, ...all].join("\n"));
  };
  const program = ({ vertex, fragment, afterVertex = "", afterFragment = "" }: Parts) =>
    new LateProgram(gl, (): Texts => ({
      vertex: stage(vertex, afterVertex),
      fragment: stage(fragment, afterFragment),
      units: unitsOf([...vertex, ...fragment]),
    }));
  const inScene = (vertex: string[], fragment: string[]) =>
    program({ vertex, fragment, afterVertex: toClip });
  const ofPicture = (fragment: string[], afterFragment = "") =>
    program({ vertex: [whole], fragment, afterFragment });

  const surfelSprites = [instance, surfel, surfelSprite, fetch, sprites, mark, surfelMark,
                         renamed(surfelSpriteVertex, "place_sprite"), sprite];
  const surfelSolids = [instance, surfel, fetch, mark, surfelMark, surfelVertex,
                        separateTriangles, solid];
  const voxelSprites = [instance, voxel, voxelSprite, fetch, sprites, mark, voxelMark,
                        renamed(voxelSpriteVertex, "place_sprite"), sprite];
  return {
    surfelDepth: {
      sprites: inScene(surfelSprites, [spriteFootprint, discDepth]),
      solids: inScene(surfelSolids, [quadFootprint, discDepth]),
    },
    surfelSum: {
      sprites: inScene(surfelSprites, [spriteFootprint, discSum]),
      solids: inScene(surfelSolids, [quadFootprint, discSum]),
    },
    voxel: {
      sprites: inScene(voxelSprites, [voxelSpriteFragment]),
      solids: inScene([instance, voxel, fetch, mark, voxelMark, voxelFaces, separateTriangles, solid], [flat]),
    },
    point: inScene([instance, fetch, point], [pointFragment]),
    strip: inScene([instance, fetch, stripVertex], [stripFragment]),
    stripDepth: inScene([instance, fetch, stripVertex], [nothing]),
    back: inScene([instance, fetch, back], [nothing]),
    floor: program({
      vertex: [floorVertex], fragment: [floorFragment],
      afterVertex: `side_by_w = side * gl_Position.w; ${toClip}`,
    }),
    seeThrough: ofPicture([seeThrough]),
    pullSums: ofPicture([mean, pullSums]),
    pull: ofPicture([pull]),
    push: ofPicture([push]),
    resolve: ofPicture([mean, resolve]),
    shadow: inScene([instance, fetch, shading, shadow], [nothing]),
    shadowBlur: ofPicture([shadowBlur]),
    floorShadow: ofPicture([shading, floorShadow]),
    open: ofPicture([shading, open]),
    light: ofPicture([shading, light]),
    present: ofPicture([srgb, present]),
    outlines: ofPicture([srgb, outlines], "color.rgb = srgb_from_linear(color.rgb);"),
    depthBits: ofPicture([depthBits]),
  };
}
export type Programs = ReturnType<typeof makePrograms>;

export function freePrograms(programs: Programs): void {
  for (const each of Object.values(programs))
    for (const program of each instanceof LateProgram ? [each] : Object.values(each)) program.free();
}
