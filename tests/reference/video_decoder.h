#pragma once

#include <memory>
#include <vector>

#include <glm/glm.hpp>
#include <glm/gtc/type_precision.hpp>

#include "pointreel/bytes.h"
#include "pointreel/chunks.h"
#include "pointreel/error.h"
#include "tests/reference/context_decoder.h"

namespace pointreel::reference {

/// The points of a frame of layered depth video: those of the patches, in their order and row by
/// row, then the leftovers.
struct VideoPoints {
  std::vector<glm::dvec3> positions;  ///< in world coordinates
  std::vector<glm::dvec3> normals;    ///< of each point, 0 where unknown
  std::vector<glm::u16vec3> colors;   ///< of each point, where 65535 is full intensity; or empty
};

/// Decodes the frames of a group, one after another, as codec/FORMAT.md describes them ("Video"),
/// in the simplest way and without any code of the codec, but for the decoder of AV1. Refuses
/// everything that the description tells a reader to refuse. For small frames only, since time is
/// not bounded.
class VideoDecoder {
 public:
  /// `tables`: tables 1, which leftovers may need.
  explicit VideoDecoder(const Tables& tables);
  VideoDecoder(VideoDecoder&&) noexcept;
  VideoDecoder& operator=(VideoDecoder&&) noexcept;
  ~VideoDecoder();

  /// Decodes the next frame of the group, or the first one of a new group. Fails if the chunks are
  /// damaged, or are not those of the next frame. After an error, a group has to begin anew.
  Result<VideoPoints> next(const Chunks<ByteView>& chunks);

 private:
  struct Group;
  Tables tables_;
  std::unique_ptr<Group> group_;
};

}  // namespace pointreel::reference
