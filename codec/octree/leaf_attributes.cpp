#include "codec/octree/leaf_attributes.h"

#include <bit>
#include <cmath>

namespace pointreel {
namespace {

constexpr std::uint16_t kNoNormal = 255;
constexpr float kOctahedralSteps = 254.0f;

std::uint16_t modulo(int value, int bits) {
  return static_cast<std::uint16_t>(value & ((1 << bits) - 1));
}

float sign_not_zero(float v) { return v >= 0.0f ? 1.0f : -1.0f; }

/// Folds the octahedron's lower half over the corners of its upper half, or back.
glm::vec2 fold(const glm::vec2& v) {
  return {(1.0f - std::abs(v.y)) * sign_not_zero(v.x), (1.0f - std::abs(v.x)) * sign_not_zero(v.y)};
}

std::uint16_t to_step(float v) {
  return static_cast<std::uint16_t>((v * 0.5f + 0.5f) * kOctahedralSteps + 0.5f);
}

float from_step(std::uint16_t step) {
  return static_cast<float>(step) / kOctahedralSteps * 2.0f - 1.0f;
}

}  // namespace

Codes color_codes(const glm::u16vec3* colors, std::size_t count, int bits) {
  Codes codes(count);
  for (std::size_t i = 0; i < count; ++i) {
    glm::ivec3 c(colors[i]);
    if (bits == 8) c = (c + 128) / 257;
    codes[i] = {modulo(c.g, bits), modulo(c.r - c.g, bits), modulo(c.b - c.g, bits)};
  }
  return codes;
}

std::vector<glm::u16vec3> colors_from_codes(const Codes& codes, int bits) {
  const int scale = bits == 8 ? 257 : 1;
  std::vector<glm::u16vec3> colors;
  colors.reserve(codes.size());
  for (const glm::u16vec3& code : codes) {
    const int r = modulo(code.y + code.x, bits), b = modulo(code.z + code.x, bits);
    colors.push_back(glm::u16vec3(r * scale, code.x * scale, b * scale));
  }
  return colors;
}

Codes normal_codes(const glm::i16vec3* normals, std::size_t count) {
  Codes codes(count);
  for (std::size_t i = 0; i < count; ++i) {
    const glm::vec3 n(normals[i]);
    const float length = std::abs(n.x) + std::abs(n.y) + std::abs(n.z);
    if (length == 0.0f) {
      codes[i] = {kNoNormal, kNoNormal, 0};
      continue;
    }
    glm::vec2 v = glm::vec2(n) / length;
    if (n.z < 0.0f) v = fold(v);
    codes[i] = {to_step(v.x), to_step(v.y), 0};
  }
  return codes;
}

std::vector<glm::vec3> normals_from_codes(const Codes& codes) {
  std::vector<glm::vec3> normals;
  normals.reserve(codes.size());
  for (const glm::u16vec3& code : codes) {
    if (code.x == kNoNormal || code.y == kNoNormal) {
      normals.push_back(glm::vec3(0.0f));
      continue;
    }
    glm::vec2 v(from_step(code.x), from_step(code.y));
    const float z = 1.0f - std::abs(v.x) - std::abs(v.y);
    if (z < 0.0f) v = fold(v);
    normals.push_back(glm::normalize(glm::vec3(v, z)));
  }
  return normals;
}

Codes inherit(const Svo& svo, const Codes& codes, int from_level, int to_level) {
  Codes parents = codes;
  for (int level = from_level; level < to_level; ++level) {
    Codes children(svo.node_count(level + 1));
    glm::u16vec3* child = children.data();
    const std::uint8_t* mask = svo.masks.data() + svo.level_begin[static_cast<std::size_t>(level)];
    for (const glm::u16vec3& code : parents) {
      for (int count = std::popcount(*mask++); count > 0; --count) *child++ = code;
    }
    parents.swap(children);
  }
  return parents;
}

Bytes code_differences(const Codes& codes, const Codes& predicted, const CodeShape& shape) {
  Bytes bytes(shape.bytes(codes.size()));
  std::uint8_t* byte = bytes.data();
  for (int component = 0; component < shape.components; ++component) {
    for (int shift = shape.bits - 8; shift >= 0; shift -= 8) {
      for (std::size_t i = 0; i < codes.size(); ++i) {
        const int difference = codes[i][component] - predicted[i][component];
        *byte++ = static_cast<std::uint8_t>(difference >> shift);
      }
    }
  }
  return bytes;
}

Codes add_differences(ByteView bytes, const Codes& predicted, const CodeShape& shape) {
  Codes codes = predicted;
  const std::uint8_t* byte = bytes.data();
  for (int component = 0; component < shape.components; ++component) {
    for (int shift = shape.bits - 8; shift >= 0; shift -= 8) {
      for (glm::u16vec3& code : codes) {
        code[component] = modulo(code[component] + (*byte++ << shift), shape.bits);
      }
    }
  }
  return codes;
}

}  // namespace pointreel
