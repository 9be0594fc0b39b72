#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "pointreel/bytes.h"
#include "pointreel/chunks.h"
#include "pointreel/codec.h"
#include "pointreel/error.h"
#include "pointreel/package.h"

namespace pointreel {

/// What of a frame is wanted. Chunks are stored in the order geometry, colours, normals, and what
/// is fetched is a prefix, one range a layer: normals bring the colours with them.
struct FetchRequest {
  std::uint32_t layers = ~0u;  ///< so many from the base on; at least 1
  bool colors = true;
  bool normals = true;
  std::stop_token stop = {};  ///< a fetch that is asked to stop fails soon
  /// Past caches on the way, as far as they obey: for what came damaged.
  bool fresh = false;
  /// Layers before it are there already: what is fetched begins with it. Below the layers there
  /// are.
  std::uint32_t first_layer = 0;
};

/// One layer of a frame as it was fetched.
struct FetchedLayer {
  Bytes bytes;
  Chunks<std::uint32_t>
      sizes;  ///< of the chunks within `bytes`, in stored order; 0 where not fetched

  Chunks<ByteView> view() const;
};

/// A frame as it came: either layers of a package, or a whole PLY or .drc file.
struct FetchedFrame {
  std::vector<FetchedLayer> layers;
  std::shared_ptr<const ContextTables> tables;  ///< of the package that `layers` are of, if any
  Bytes file;                                   ///< used if `layers` is empty
  std::string file_name;                        ///< of `file`, for errors

  std::uint64_t size() const;  ///< bytes that came
};

/// What a link has carried so far.
struct LinkUse {
  std::uint64_t bytes = 0;  ///< of bodies
  /// When at least one answer was under way, its first byte here and its last not: `bytes` over it
  /// is the link's rate, however many are fetched at once.
  std::chrono::microseconds receiving{0};
  std::chrono::microseconds busy{0};  ///< when at least one was asked for or under way
  /// From a request to the first byte of its answer: the least of late; 0 if not known.
  std::chrono::microseconds round_trip{0};
};

/// Where frames come from.
class Source {
 public:
  virtual ~Source() = default;

  virtual const Manifest& manifest() const = 0;

  /// `frame` < manifest().frame_count(). May be called by many threads at once. Blocks through
  /// failures that may pass (no connection, no answer in time, 5xx), trying again; an error is what
  /// will not pass, or that the fetch was stopped or cancelled. The bytes are not to be trusted,
  /// except that there are as many as `sizes` says.
  virtual Result<FetchedFrame> fetch(std::uint32_t frame, const FetchRequest& request) = 0;

  /// Makes fetches under way, and all later ones, fail soon. From any thread.
  virtual void cancel() {}

  /// One line while fetches wait for something to pass, as in "host:8090: nothing answers there;
  /// trying again"; none when all is well. From any thread.
  virtual std::optional<std::string> trouble() const { return std::nullopt; }

  /// Nothing where there is no link. From any thread.
  virtual LinkUse link_use() const { return {}; }
};

/// The package's tables, from the bytes that came for the manifest's entry: what the entry
/// promises, or an error. Trust: the bytes may be hostile; context_tables.h tells how they are
/// read.
Result<std::shared_ptr<const ContextTables>> read_tables(const PackageFile& file, ByteView bytes);

struct SourceOptions {
  // For folders of files, which say neither.
  double fps = 30.0;
  char up = 'y';
  // For HTTP and WebSocket.
  std::string token;    ///< bearer token, sent if not empty
  std::string ca_file;  ///< PEM certificates to trust for https and wss; empty: the system's
  std::chrono::milliseconds connect_timeout{2'000};  ///< TLS included
  /// Of a connection that is made, without a byte. Doubles, up to four times as much, while a
  /// server that can be reached stays silent.
  std::chrono::milliseconds stall_timeout{1'500};
  std::chrono::milliseconds first_backoff{100};  ///< doubles with each attempt
  std::chrono::milliseconds max_backoff{500};
  std::stop_token stop = {};  ///< asked to stop, opening a source fails soon
  /// Source::trouble whenever it changes, of sources that trouble is told of while they are opened:
  /// HTTP. Called by any thread.
  std::function<void(const std::optional<std::string>&)> on_trouble = {};
  int open_attempts = 4;  ///< to open a source; what is fetched later is tried without end
};

/// A range of a layer's file that holds what is wanted of a frame.
struct LayerRange {
  const LayerFile* file = nullptr;  ///< in the manifest
  std::uint64_t offset = 0;
  Chunks<std::uint32_t> sizes;
};

/// No frame of any real reel comes near this; a manifest that says otherwise is not believed.
inline constexpr std::uint64_t kMaxFrameBytes = std::uint64_t{1} << 30;

/// The ranges to fetch, in the order of the layers. An error if they exceed kMaxFrameBytes.
Result<std::vector<LayerRange>> ranges_of(const Manifest& manifest, std::uint32_t frame,
                                          const FetchRequest& request);

}  // namespace pointreel
