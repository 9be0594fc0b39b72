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

/// Frames as they came, still coded: so much smaller than decoded that seconds of them can be kept
/// ahead of the playhead, and behind it for who comes back. A frame's layers come one by one, each
/// once. A plain value: whoever shares it among threads locks it.
class LayerStore {
 public:
  /// `layer_count` >= 1: layers of the reel; 1 for files.
  explicit LayerStore(std::uint32_t layer_count) : layer_count_(layer_count) {}

  // What is there.

  // What is wanted of a frame begins with the base: `wanted.first` is 0.

  /// Layers from the base on that are there with all attributes that are wanted; at most
  /// `wanted.end`.
  std::uint32_t usable(std::uint32_t frame, const LayerRange& wanted) const;
  /// Calls `tell` with each frame of which layers are there, in order, and with how many from the
  /// base on, whatever their attributes.
  void for_each(const std::function<void(std::uint32_t frame, std::uint32_t layers)>& tell) const;
  /// At least one of the layers wanted is being fetched.
  bool coming(std::uint32_t frame, const LayerRange& wanted) const;
  /// The first `layers` of a frame, which are there.
  FetchedFrame get(std::uint32_t frame, std::uint32_t layers) const;
  /// The longest that fetching any of the frame took since it was last taken, in milliseconds.
  double fetch_ms(std::uint32_t frame) const;
  double take_fetch_ms(std::uint32_t frame);
  /// No layer from this one on can be had of the frame.
  std::uint32_t limit(std::uint32_t frame) const;

  // Fetching.

  /// The first layers in a row that are wanted and neither there nor coming; they are coming from
  /// now on. Nothing if there are none.
  std::optional<FetchRequest> begin(std::uint32_t frame, const LayerRange& wanted);
  /// `came` has the layers asked for, or is a file. What came of a stopped request is kept too.
  void arrived(const FetchRequest& request, FetchedFrame came, double ms);
  /// Its layers are wanted again from now on.
  void failed(const FetchRequest& request);
  /// These layers cannot be had. True if layers before them can: the frame has to do with
  /// those.
  bool give_up(const FetchRequest& request);
  std::size_t requests() const { return running_.size(); }  ///< that are not answered yet
  /// Stops the requests for frames for which `stale` says so.
  void stop(const std::function<bool(std::uint32_t)>& stale);

  // What turned out to be broken.

  /// The layer does not decode. The first time it is forgotten, to be fetched once more: true. The
  /// second time it is given up, with all finer ones: false.
  bool broken(std::uint32_t frame, std::uint32_t layer);

  // Keeping.

  std::uint64_t bytes() const { return bytes_; }  ///< that are there
  /// What is being fetched, if these requests bring what those before them have brought on average.
  std::uint64_t coming_bytes() const;
  /// If more than `budget` bytes are there, forgets frames, those first whose `rank` is greatest,
  /// until it is well below; none whose rank is 0.
  void shrink(std::uint64_t budget, const std::function<std::uint64_t(std::uint32_t)>& rank);
  /// What could not be had of a frame may be tried again.
  void forgive(const std::function<bool(std::uint32_t)>& which);

 private:
  struct Slot {
    enum class State { absent, coming, here } state = State::absent;
    std::uint64_t request = 0;  ///< the id of the request that it is coming with
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
    FetchRequest request;
    std::stop_source stop;
  };

  static bool covers(const Slot& slot, const LayerRange& wanted) {
    return (slot.colors || !wanted.colors) && (slot.normals || !wanted.normals);
  }
  std::uint32_t clamped(const Record* record, const LayerRange& wanted) const;
  const Record* find(std::uint32_t frame) const;
  void drop(Record& record, Slot& slot);
  void unmark(const FetchRequest& request);

  const std::uint32_t layer_count_;
  std::map<std::uint32_t, Record> records_;
  std::map<std::uint64_t, Running> running_;
  std::uint64_t next_id_ = 1, bytes_ = 0;
  std::uint64_t arrived_bytes_ = 0, arrived_requests_ = 0;
};

}  // namespace pointreel
