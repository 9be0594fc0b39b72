#include "client/record/picture_sequence.h"

namespace pointreel {

Result<void> PictureSequence::add(const Image& picture, std::uint64_t) {
  return write_png(path_.at(count_++), picture);
}

}  // namespace pointreel
