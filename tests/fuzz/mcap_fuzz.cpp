// Opening any bytes as an MCAP recording gives messages or an error, and so does reading each.
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "codec/formats/mcap.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace pointreel;
  const auto require = [](bool condition) {
    if (!condition) std::abort();
  };
  const auto one_line = [](const std::string& text) {
    return !text.empty() && text.find('\n') == std::string::npos;
  };
  const auto recording = McapRecording::open(ByteSource(ByteView(data, size)), {}, 4u << 20);
  if (!recording) {
    require(one_line(recording.error().message));
    return 0;
  }
  require((*recording)->size() > 0 && (*recording)->size() <= size);
  for (std::size_t i = 0; i < (*recording)->size() && i < 16; ++i) {
    const Result<Bytes> message = (*recording)->read(i);
    require(message || one_line(message.error().message));
    require(i == 0 || (*recording)->time_ns(i) >= (*recording)->time_ns(i - 1));
  }
  return 0;
}
