#include <charconv>
#include <deque>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "client/source/source.h"
#include "common/base/try.h"
#include "common/http/http_client.h"
#include "pointreel/package.h"
#include "tests/load/viewers.h"

namespace pointreel {
namespace {

/// A viewer that is this many frames behind requests nothing more.
constexpr std::size_t kMostBehind = 30;

class PackageViewer : public CrowdMember {
 public:
  PackageViewer(std::shared_ptr<const PackageRequests> requests, double phase, LoadRecord& record)
      : requests_(std::move(requests)), phase_(phase), record_(record) {}

  LoadClock::time_point on_due(LoadClock::time_point now) override {
    if (!begun_) {
      // The viewer acts as if it had started to play long ago.
      begun_ = now - std::chrono::duration_cast<LoadClock::duration>(requests_->loop * phase_);
      while (due() < now) ++next_;
      return due();
    }
    const PackageRequests::Frame& frame = requests_->frames[next_ % requests_->frames.size()];
    if (waiting_.size() < kMostBehind) {
      send(frame.requests);
      waiting_.push_back({due(), frame.layers});
    } else if (record_.on) {
      ++record_.figures.incomplete;
    }
    ++next_;
    return due();
  }

 private:
  struct Waiting {
    LoadClock::time_point due;
    unsigned layers;
  };

  LoadClock::time_point due() const {
    const auto loops = static_cast<std::int64_t>(next_ / requests_->frames.size());
    return *begun_ + loops * requests_->loop +
           requests_->frames[next_ % requests_->frames.size()].due;
  }

  bool on_data() override {
    const std::string_view text = buffer();
    const auto end = text.find("\r\n\r\n");
    if (end == std::string_view::npos) return text.size() < kMaxHead;
    const std::string_view head = text.substr(0, end);
    if (!head.starts_with("HTTP/1.1 20") || waiting_.empty()) return false;
    constexpr std::string_view kLength = "Content-Length: ";
    const auto at = head.find(kLength);
    std::uint64_t length = 0;
    if (at == std::string_view::npos ||
        std::from_chars(head.data() + at + kLength.size(), head.data() + head.size(), length).ec !=
            std::errc())
      return false;
    take(end + 4);
    const bool here = buffer().size() >= length;
    skip(length);
    return !here || on_skipped();
  }

  bool on_skipped() override {
    if (--waiting_.front().layers > 0) return true;
    record_.whole(
        std::chrono::duration<double, std::milli>(LoadClock::now() - waiting_.front().due).count());
    waiting_.pop_front();
    return true;
  }

  const std::shared_ptr<const PackageRequests> requests_;
  const double phase_;
  LoadRecord& record_;
  std::optional<LoadClock::time_point> begun_;
  std::size_t next_ = 0;
  std::deque<Waiting> waiting_;
};

}  // namespace

void LoadRecord::whole(double delay_ms) {
  if (!on) return;
  ++figures.frames;
  figures.delays_ms.push_back(static_cast<float>(delay_ms));
}

Result<std::shared_ptr<const PackageRequests>> package_requests(const LoadOptions& options,
                                                                const Url& url) {
  SourceOptions source;
  source.token = options.token;
  HttpClient client(source);
  const std::string manifest_url = options.url + "/" + kManifestName;
  const Bytes text = TRY(client.get(manifest_url, kMaxManifestBytes));
  const auto manifest = parse_manifest({reinterpret_cast<const char*>(text.data()), text.size()});
  if (!manifest) return fail_at(manifest_url, manifest.error());

  auto requests = std::make_shared<PackageRequests>();
  requests->loop = std::chrono::microseconds(manifest->duration_us);
  const std::string authorization =
      options.token.empty() ? "" : fmt::format("Authorization: Bearer {}\r\n", options.token);
  for (std::uint32_t i = 0; i < manifest->frame_count(); ++i) {
    const auto ranges = ranges_of(*manifest, i, {});
    if (!ranges) return tl::unexpected(ranges.error());
    PackageRequests::Frame frame;
    frame.due = std::chrono::microseconds(frame_time_us(*manifest, i));
    for (const FileRange& range : *ranges) {
      if (total(range.sizes) == 0) continue;
      ++frame.layers;
      frame.requests +=
          fmt::format("GET {}/{} HTTP/1.1\r\nHost: {}:{}\r\n{}Range: bytes={}-{}\r\n\r\n",
                      url.target, range.file->path, url.host, url.port, authorization, range.offset,
                      range.offset + total(range.sizes) - 1);
    }
    requests->frames.push_back(std::move(frame));
  }
  if (requests->frames.empty()) return fail(options.url + ": the reel has no frames");
  return requests;
}

std::unique_ptr<CrowdMember> package_viewer(std::shared_ptr<const PackageRequests> requests,
                                            double phase, LoadRecord& record) {
  return std::make_unique<PackageViewer>(std::move(requests), phase, record);
}

}  // namespace pointreel
