#pragma once

#include <cstdint>

#include "pointreel/bytes.h"

namespace pointreel {

/// The three chunks of a layer of a frame, in the order in which they are stored, or something that
/// each of them has: their bytes, views of their bytes, or their sizes. A chunk that the frame does
/// not have, or that was not fetched, is empty.
template <class T>
struct Chunks {
  T geometry{}, colors{}, normals{};

  bool operator==(const Chunks&) const = default;
};

/// The sum of three sizes.
template <class T>
std::uint64_t total(const Chunks<T>& sizes) {
  return std::uint64_t{sizes.geometry} + sizes.colors + sizes.normals;
}

/// The size of three chunks together, in bytes.
inline std::uint64_t total(const Chunks<Bytes>& chunks) {
  return chunks.geometry.size() + chunks.colors.size() + chunks.normals.size();
}

}  // namespace pointreel
