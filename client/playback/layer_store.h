#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <stop_token>
#include <vector>

#include "client/source/source.h"

namespace pointreel {

/// What of a frame is wanted: so many layers from the base on, with these attributes.
struct LayerSet {
  std::uint32_t layers = ~0u;
  bool colors = true, normals = true;

  bool operator==(const LayerSet&) const = default;
};

/// Layers of one frame that somebody is to fetch.
struct FetchJob {
  std::uint64_t id = 0;
  std::uint32_t frame = 0;
  std::uint32_t first = 0, last = 0;  ///< layers [first, last)
  bool colors = true, normals = true;
  bool fresh = false;    ///< one of them came damaged before
  std::stop_token stop;  ///< nobody waits for it any more
};

/// Frames as they came, still coded: so much smaller than decoded that seconds of them can be kept
/// ahead of the playhead, and behind it for who comes back. A frame's layers come one by one, each
/// once. A plain value: whoever shares it among threads locks it.
class LayerStore {
 public:
  /// `layer_count` >= 1: layers of the reel; 1 for files.
  explicit LayerStore(std::uint32_t layer_count) : layer_count_(layer_count) {}

  // What is there.

  /// Layers from the base on that are there with all attributes that are wanted; at most
  /// `wanted.layers`.
  std::uint32_t usable(std::uint32_t frame, const LayerSet& wanted) const;
  /// Calls `tell` with each frame of which layers are there, in order, and with how many from the
  /// base on, whatever their attributes.
  void for_each(const std::function<void(std::uint32_t frame, std::uint32_t layers)>& tell) const;
  /// At least one of the layers wanted is being fetched.
  bool coming(std::uint32_t frame, const LayerSet& wanted) const;
  /// The first `layers` of a frame, which are there.
  FetchedFrame copy(std::uint32_t frame, std::uint32_t layers) const;
  /// The longest that fetching any of the frame took since it was last taken, in milliseconds.
  double fetch_ms(std::uint32_t frame) const;
  double take_fetch_ms(std::uint32_t frame);
  /// No layer from this one on can be had of the frame.
  std::uint32_t limit(std::uint32_t frame) const;

  // Fetching.

  /// The first layers in a row that are wanted and neither there nor coming; they are coming from
  /// now on. Nothing if there are none.
  std::optional<FetchJob> begin(std::uint32_t frame, const LayerSet& wanted);
  /// `came` has the job's layers, or is a file. What has come of a stopped job is kept too.
  void arrived(const FetchJob& job, FetchedFrame came, double ms);
  /// Its layers are wanted again from now on.
  void failed(const FetchJob& job);
  /// The job's layers cannot be had. True if layers before them can: the frame has to do with
  /// those.
  bool give_up(const FetchJob& job);
  std::size_t jobs() const { return running_.size(); }  ///< that are not answered yet
  /// Stops the jobs of frames for which `stale` says so.
  void stop(const std::function<bool(std::uint32_t)>& stale);

  // What turned out to be broken.

  /// The layer does not decode. The first time it is forgotten, to be fetched once more: true. The
  /// second time it is given up, with all finer ones: false.
  bool broken(std::uint32_t frame, std::uint32_t layer);

  // Keeping.

  std::uint64_t bytes() const { return bytes_; }  ///< that are there
  /// What is being fetched, if its jobs bring what those before them have brought on average.
  std::uint64_t coming_bytes() const;
  /// If more than `budget` bytes are there, forgets frames, those first whose `rank` is greatest,
  /// until it is well below; none whose rank is 0.
  void shrink(std::uint64_t budget, const std::function<std::uint64_t(std::uint32_t)>& rank);
  /// What could not be had of a frame may be tried again.
  void forgive(const std::function<bool(std::uint32_t)>& which);

 private:
  struct Slot {
    enum class State { absent, coming, here } state = State::absent;
    std::uint64_t job = 0;  ///< that it is coming with
    bool colors = false, normals = false;
    FetchedLayer layer;
  };
  struct Record {
    std::vector<Slot> slots;
    std::shared_ptr<const ContextTables> tables;
    std::optional<FetchedFrame> file;  ///< instead of layers
    std::uint32_t refetched = 0;       ///< a bit for each layer
    std::uint32_t limit = ~0u;
    std::uint64_t bytes = 0;
    double fetch_ms = 0.0;
  };
  struct Running {
    FetchJob job;
    std::stop_source stop;
  };

  static bool covers(const Slot& slot, const LayerSet& wanted) {
    return (slot.colors || !wanted.colors) && (slot.normals || !wanted.normals);
  }
  std::uint32_t clamped(const Record* record, const LayerSet& wanted) const;
  const Record* find(std::uint32_t frame) const;
  void drop(Record& record, Slot& slot);
  void unmark(const FetchJob& job);

  const std::uint32_t layer_count_;
  std::map<std::uint32_t, Record> records_;
  std::map<std::uint64_t, Running> running_;
  std::uint64_t next_id_ = 1, bytes_ = 0;
  std::uint64_t arrived_bytes_ = 0, arrived_jobs_ = 0;
};

}  // namespace pointreel
