#include <algorithm>
#include <chrono>
#include <cstring>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "codec/live/live.h"
#include "common/base/byte_io.h"
#include "pointreel/bytes.h"
#include "tests/load/viewers.h"

namespace pointreel {
namespace {

/// The part of RFC 6455 that a viewer needs if it looks only at the first bytes of each message.
class LiveViewer : public CrowdMember {
 public:
  LiveViewer(const Url& url, const std::string& token, LoadRecord& record)
      : record_(record),
        request_(fmt::format("GET {} HTTP/1.1\r\nHost: {}:{}\r\n{}Connection: Upgrade\r\n"
                             "Upgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
                             "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n",
                             url.target, url.host, url.port,
                             token.empty() ? "" : "Authorization: Bearer " + token + "\r\n")) {}

  LoadClock::time_point on_due(LoadClock::time_point now) override {
    send(std::exchange(request_, {}));
    return CrowdMember::on_due(now);
  }

 private:
  enum Opcode : unsigned { kContinuation = 0, kText = 1, kBinary = 2, kClose = 8, kPing = 9 };

  bool on_data() override {
    if (!upgraded_) {
      const auto end = buffer().find("\r\n\r\n");
      if (end == std::string_view::npos) return buffer().size() < kMaxHead;
      if (!buffer().starts_with("HTTP/1.1 101")) return false;
      take(end + 4);
      upgraded_ = true;
      return true;
    }
    if (frame_left_ == 0 && !begin_frame()) return valid_;
    // The first bytes of a message are kept, because they tell which layer it is; the rest is
    // skipped.
    if (control_ || head_.size() < wanted_head()) {
      const std::size_t n = std::min<std::uint64_t>(
          {frame_left_, buffer().size(), control_ ? frame_left_ : wanted_head() - head_.size()});
      (control_ ? control_text_ : head_).append(buffer().substr(0, n));
      take(n);
      frame_left_ -= n;
      if (frame_left_ == 0) return end_frame();
      return true;
    }
    const bool here = buffer().size() >= frame_left_;
    skip(frame_left_);
    return !here || on_skipped();
  }

  bool on_skipped() override {
    frame_left_ = 0;
    return end_frame();
  }

  static std::size_t wanted_head() { return kLiveHeaderSize; }

  /// Reads the header of a WebSocket frame. Returns false if it has not arrived completely, or is
  /// invalid; then `valid_` is false.
  bool begin_frame() {
    const std::string_view text = buffer();
    const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
    if (text.size() < 2) return false;
    const unsigned opcode = byte(0) & 15u;
    std::uint64_t length = byte(1);
    if (length > 127) return valid_ = false;  // servers do not mask
    const std::size_t more = length == 127 ? 8 : length == 126 ? 2 : 0;
    if (text.size() < 2 + more) return false;
    if (more > 0) length = 0;
    for (std::size_t i = 0; i < more; ++i) length = length << 8 | byte(2 + i);
    take(2 + more);
    final_ = (byte(0) & 128) != 0;
    control_ = opcode >= kClose;
    opcode_ = opcode;
    if (!control_ && opcode != kContinuation) {
      binary_ = opcode == kBinary;
      head_.clear();
    }
    control_text_.clear();
    frame_left_ = length;
    if (control_ && length > 125) return valid_ = false;
    if (length == 0) return valid_ = end_frame();
    return true;
  }

  bool end_frame() {
    if (control_) {
      if (opcode_ == kPing) {
        // The mask consists of zeros.
        std::string pong{'\x8a', static_cast<char>(0x80 | control_text_.size()), 0, 0, 0, 0};
        send(pong + control_text_);
      }
      return opcode_ != kClose;
    }
    if (final_ && binary_) on_layer();
    return true;
  }

  /// Called when a whole layer has arrived. `head_` holds its header, in the order of
  /// common/PROTOCOL.md.
  void on_layer() {
    ByteReader in({reinterpret_cast<const std::uint8_t*>(head_.data()), head_.size()});
    in.get<std::uint32_t>();
    const auto frame = in.get<std::uint32_t>();
    const auto captured = std::chrono::microseconds(in.get<std::uint64_t>());
    in.get<std::uint32_t>();
    const auto layer = in.get<std::uint8_t>();
    const auto layers = in.get<std::uint8_t>();
    if (!in.ok()) return;
    if (layer == 0) {
      if (record_.on && frame_) {
        record_.figures.incomplete += !whole_;
        record_.figures.missing += frame > *frame_ ? frame - *frame_ - 1 : 0;
      }
      frame_ = frame;
      whole_ = false;
    }
    if (frame_ != frame || layer + 1 != layers) return;
    whole_ = true;
    const auto now = std::chrono::system_clock::now().time_since_epoch();
    record_.whole(std::chrono::duration<double, std::milli>(now - captured).count());
  }

  LoadRecord& record_;
  std::string request_;
  bool upgraded_ = false, valid_ = true;
  // The WebSocket frame that is arriving.
  std::uint64_t frame_left_ = 0;
  bool final_ = false, control_ = false, binary_ = false;
  unsigned opcode_ = 0;
  std::string head_, control_text_;
  // The frame of the stream that is arriving.
  std::optional<std::uint32_t> frame_;
  bool whole_ = false;
};

}  // namespace

std::unique_ptr<CrowdMember> live_viewer(const Url& url, const std::string& token,
                                         LoadRecord& record) {
  return std::make_unique<LiveViewer>(url, token, record);
}

}  // namespace pointreel
