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

/// Frames as they came, still coded. They are so much smaller than decoded ones that seconds of
/// them can be kept ahead of the playhead, and behind it in case the user goes back. Each layer of
/// a frame comes once. A plain value without a lock of its own.
class LayerStore {
 public:
  /// `layer_count` >= 1: how many layers the reel has; 1 for files.
  explicit LayerStore(std::uint32_t layer_count) : layer_count_(layer_count) {}

  // What has come. `wanted` always begins with the base: `wanted.first` is 0.

  /// How many layers from the base on have come with all attributes that are wanted; no more than
  /// `wanted.end`.
  std::uint32_t usable(std::uint32_t frame, const LayerRange& wanted) const;
  /// Calls `tell` for each frame of which layers have come, in order, with the number of layers
  /// from the base on, whatever their attributes.
  void for_each(const std::function<void(std::uint32_t frame, std::uint32_t layers)>& tell) const;
  /// Whether at least one of the layers wanted is being fetched.
  bool coming(std::uint32_t frame, const LayerRange& wanted) const;
  /// The first `layers` of a frame, which have come.
  FetchedFrame get(std::uint32_t frame, std::uint32_t layers) const;
  /// The longest time, in milliseconds, that fetching any layer of the frame took since it was last
  /// taken.
  double fetch_ms(std::uint32_t frame) const;
  double take_fetch_ms(std::uint32_t frame);
  /// The first layer of the frame that cannot be had; all layers can if it is ~0u.
  std::uint32_t limit(std::uint32_t frame) const;

  // Fetching.

  /// Requests the first consecutive layers that are wanted and neither there nor coming. None if
  /// there are none.
  std::optional<FetchRequest> begin(std::uint32_t frame, const LayerRange& wanted);
  /// `came` has the layers asked for, or is a file. What came of a stopped request is kept too.
  void arrived(const FetchRequest& request, FetchedFrame came, double ms);
  /// The fetch was stopped: its layers may be requested again.
  void failed(const FetchRequest& request);
  /// These layers cannot be had. True if layers before them can, so that the frame is shown with
  /// those.
  bool give_up(const FetchRequest& request);
  std::size_t requests() const { return running_.size(); }  ///< not answered yet
  /// Stops the requests for frames for which `stale` says so.
  void stop(const std::function<bool(std::uint32_t)>& stale);

  /// A layer does not decode. The first time it is dropped, to be fetched once more: true. The
  /// second time it is given up together with all finer ones: false.
  bool broken(std::uint32_t frame, std::uint32_t layer);

  // Keeping.

  std::uint64_t bytes() const { return bytes_; }  ///< that have come and are kept
  /// An estimate of the bytes that are being fetched, by the mean size of earlier answers.
  std::uint64_t coming_bytes() const;
  /// If more than `budget` bytes are kept, drops frames with the greatest `rank` first, until it is
  /// well below. A frame of rank 0 is never dropped. What could not be had stays known.
  void shrink(std::uint64_t budget, const std::function<std::uint64_t(std::uint32_t)>& rank);
  /// Layers of these frames that could not be had may be tried again.
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
    std::optional<FetchedFrame> file;  ///< in place of layers
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
