#include "codec/files/mcap.h"

#include <algorithm>
#include <list>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <string_view>
#include <utility>
#include <vector>

#include <lz4frame.h>
#include <zlib.h>
#include <zstd.h>

#include "codec/files/mcap_records.h"
#include "codec/files/ply_header.h"
#include "common/base/byte_io.h"
#include "common/base/concat.h"
#include "common/base/out_of_memory.h"
#include "common/base/try.h"

namespace pointreel {
namespace mcap {

struct Channel {
  std::uint16_t schema = 0;
  std::string topic, encoding;
};

/// Where a message is: at `offset` of the unpacked chunk, or of the file if it is in none.
struct Place {
  std::uint64_t time_ns = 0, offset = 0;
  std::uint32_t chunk = 0;
  std::uint16_t channel = 0;
};
constexpr std::uint32_t kNoChunk = ~0u;

struct Chunk {
  std::uint64_t begin = 0, packed = 0, unpacked = 0;  ///< bytes of its records
  std::uint32_t checksum = 0;                         ///< CRC-32 of the unpacked ones; 0: none
  std::string compression;
  bool indexed = false;
  bool cut = false;  ///< the file ends within its records
};

}  // namespace mcap

namespace {

using namespace mcap;

constexpr std::size_t kHead = 9;          ///< of a record: what it is, and its size
constexpr std::size_t kMessageHead = 22;  ///< channel, sequence, and two times
/// Of schemas, channels and the beginnings of chunks, of which all real ones are smaller. Indexes
/// may be larger.
constexpr std::uint64_t kMaxPart = std::uint64_t{1} << 24;
constexpr std::size_t kMaxChannels = 1u << 16;
/// Writers make chunks of some megabytes.
constexpr std::uint64_t kMaxChunk = std::uint64_t{1} << 30;
constexpr std::string_view kPointCloud2 = "sensor_msgs/msg/PointCloud2";

/// Texts and numbers of a record.
class PartReader {
 public:
  explicit PartReader(ByteView bytes) : reader_(bytes) {}
  template <class T>
  T get() {
    return reader_.get<T>();
  }
  std::string text() {
    const auto size = reader_.get<std::uint32_t>();
    const ByteView rest = reader_.rest();
    if (!reader_.ok() || size > rest.size()) {
      cut_ = true;
      return {};
    }
    std::string text(reinterpret_cast<const char*>(rest.data()), size);
    reader_ = ByteReader(rest.subspan(size));
    return text;
  }
  bool ok() const { return reader_.ok() && !cut_; }
  ByteView rest() const { return reader_.rest(); }

 private:
  ByteReader reader_;
  bool cut_ = false;
};

/// As much as the first bytes of compressed ones give.
Result<std::size_t> unpack_cut_zstd(ByteView packed, Bytes& bytes) {
  const std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> context(ZSTD_createDCtx(),
                                                                     ZSTD_freeDCtx);
  if (context == nullptr) return fail(ErrorCode::limit, "out of memory");
  ZSTD_inBuffer in{packed.data(), packed.size(), 0};
  ZSTD_outBuffer out{bytes.data(), bytes.size(), 0};
  for (std::size_t before = ~std::size_t{0}; before != in.pos + out.pos;) {
    before = in.pos + out.pos;
    if (ZSTD_isError(ZSTD_decompressStream(context.get(), &out, &in))) break;
  }
  return out.pos;
}

/// `records`: unpacked. What is left of a chunk that is cut off cannot be checked.
Result<void> check_sum(const Chunk& chunk, ByteView records) {
  if (chunk.cut || chunk.checksum == 0 ||
      crc32_z(0, records.data(), records.size()) == chunk.checksum)
    return {};
  return fail("its checksum does not match");
}

Result<Bytes> unpack(const Chunk& chunk, ByteView packed) {
  Bytes bytes(static_cast<std::size_t>(chunk.unpacked));
  std::size_t size = 0;
  if (chunk.compression == "zstd" && chunk.cut) {
    size = TRY(unpack_cut_zstd(packed, bytes));
  } else if (chunk.compression == "zstd") {
    size = ZSTD_decompress(bytes.data(), bytes.size(), packed.data(), packed.size());
    if (ZSTD_isError(size)) return fail("its zstd is damaged");
  } else {
    LZ4F_dctx* context = nullptr;
    if (LZ4F_isError(LZ4F_createDecompressionContext(&context, LZ4F_VERSION)))
      return fail(ErrorCode::limit, "out of memory");
    const std::unique_ptr<LZ4F_dctx, decltype(&LZ4F_freeDecompressionContext)> owner(
        context, LZ4F_freeDecompressionContext);
    std::size_t at = 0;
    while (at < packed.size() && size < bytes.size()) {
      std::size_t made = bytes.size() - size, taken = packed.size() - at;
      const std::size_t status =
          LZ4F_decompress(context, bytes.data() + size, &made, packed.data() + at, &taken, nullptr);
      const bool stuck = LZ4F_isError(status) || (made == 0 && taken == 0);
      if (stuck && chunk.cut) break;
      if (stuck) return fail("its lz4 is damaged");
      size += made;
      at += taken;
    }
  }
  if (chunk.cut) {
    bytes.resize(size);
    return bytes;
  }
  if (size != bytes.size())
    return fail(concat("unpacks to ", size, " bytes, but says ", bytes.size()));
  TRY(check_sum(chunk, bytes));
  return bytes;
}

}  // namespace

class McapRecording::Impl {
 public:
  Impl(ByteSource source, std::uint64_t max_memory, bool best_effort)
      : source_(std::move(source)), max_memory_(max_memory), best_effort_(best_effort) {}

  Result<void> open(const std::string& topic) {
    TRY(scan());
    // Chunks without an index have to be read, and all until every channel is known.
    for (std::uint32_t i = 0; i < chunks_.size(); ++i) {
      if (!chunks_[i].indexed || !unknown_.empty()) TRY(or_leave_out(read_contents(i)));
    }
    return choose(topic);
  }

  const RecordingLoss& loss() const { return loss_; }

  std::size_t size() const { return places_.size(); }
  std::uint64_t time_ns(std::size_t message) const { return places_[message].time_ns; }

  Result<Bytes> read(std::size_t message) const {
    const Place& place = places_[message];
    if (place.chunk == kNoChunk) return read_from_file(place, source_.size());
    const Chunk& chunk = chunks_[place.chunk];
    // The bytes of a chunk that fits are checked together.
    if (chunk.compression.empty() && chunk.packed > most_of_chunk()) {
      Place moved = place;
      if (place.offset > chunk.packed) return fail("is outside of its chunk");
      moved.offset += chunk.begin;
      return read_from_file(moved, chunk.begin + chunk.packed);
    }
    const auto bytes = TRY(unpacked(place.chunk));
    return part_of(*bytes, place);
  }

 private:
  /// What is wrong with a part is no error where parts may be left out.
  Result<void> or_leave_out(Result<void> taken) {
    if (taken) return taken;
    if (!best_effort_) {
      return fail(taken.error().code,
                  taken.error().message + "; pack --best-effort leaves such parts out");
    }
    if (loss_.warnings.size() < kMostWarnings)
      loss_.warnings.push_back(taken.error().message + "; it is left out");
    ++loss_.parts;
    return {};
  }

  /// The head of a record at `offset`; nothing where the file ends before.
  struct Record {
    std::uint8_t opcode = 0;
    std::uint64_t size = 0;
  };

  Result<std::optional<Record>> record_at(std::uint64_t offset) const {
    Bytes room;
    const ByteView head = TRY(source_.view(offset, kHead, room));
    if (head.size() < kHead) return std::optional<Record>();
    ByteReader reader(head);
    Record record;
    record.opcode = reader.get<std::uint8_t>();
    record.size = reader.get<std::uint64_t>();
    if (record.size > source_.size() - offset - kHead) return std::optional<Record>();
    return std::optional<Record>(record);
  }

  Result<void> scan() {
    Bytes room;
    std::uint64_t at = kMcapMagic.size();
    bool complete = false;
    for (;;) {
      const std::optional<Record> record = TRY(record_at(at));
      // What follows the record that ends the data is an index of them.
      complete |= record && record->opcode == kDataEnd;
      if (record && record->opcode == kFooter) return {};
      // Zeros are what systems leave after a crash.
      if (!record || record->opcode == 0) return complete ? Result<void>() : end_at(at);
      const std::uint64_t begin = at + kHead;
      const std::string where = concat("byte ", at);
      // Only as much as is needed.
      std::uint64_t wanted = 0;
      if (record->opcode == kSchema || record->opcode == kChannel || record->opcode == kChunk)
        wanted = std::min(record->size, kMaxPart);
      if (record->opcode == kMessage) wanted = std::min<std::uint64_t>(record->size, kMessageHead);
      if (record->opcode == kChunk) wanted = std::min<std::uint64_t>(record->size, 256);
      if (record->opcode == kMessageIndex) wanted = record->size;
      if (wanted > 0) {
        const ByteView bytes = TRY(source_.view(begin, static_cast<std::size_t>(wanted), room));
        TRY(or_leave_out(at_place(where, take(*record, bytes, begin))));
      }
      at = begin + record->size;
    }
  }

  /// The end of a recording that has no proper one. A chunk is taken as far as it is there.
  Result<void> end_at(std::uint64_t at) {
    Bytes room;
    const ByteView bytes = TRY(source_.view(at, kHead + 256, room));
    const bool in_chunk = bytes.size() > kHead && bytes[0] == kChunk &&
                          take_chunk(bytes.subspan(kHead), at + kHead, ~std::uint64_t{0});
    if (in_chunk) {
      Chunk& chunk = chunks_.back();
      chunk.packed = std::min(chunk.packed, source_.size() - chunk.begin);
      chunk.cut = true;
    }
    loss_.warnings.push_back(concat("ends early, at byte ", at, " of ", source_.size(),
                                    in_chunk ? ", within a chunk" : "",
                                    ": what comes before is read"));
    return {};
  }

  /// A record that stands by itself.
  Result<void> take(const Record& record, ByteView bytes, std::uint64_t begin) {
    if (record.opcode == kChunk) {
      Result<void> taken = take_chunk(bytes, begin, record.size);
      lost_chunk_ = !taken;
      return taken;
    }
    // The indexes of a chunk follow it.
    if (record.opcode == kMessageIndex) return lost_chunk_ ? Result<void>() : take_index(bytes);
    if (record.opcode == kMessage) return take_message(bytes, begin - kHead, kNoChunk);
    return take_description(record.opcode, bytes);
  }

  Result<void> take_description(std::uint8_t opcode, ByteView bytes) {
    PartReader part(bytes);
    const auto id = part.get<std::uint16_t>();
    if (schemas_.size() + channels_.size() > kMaxChannels)
      return fail(ErrorCode::limit, "has too many channels");
    if (opcode == kSchema) {
      std::string name = part.text();
      if (part.ok()) schemas_.emplace(id, std::move(name));
    } else if (opcode == kChannel) {
      Channel channel;
      channel.schema = part.get<std::uint16_t>();
      channel.topic = part.text();
      channel.encoding = part.text();
      if (part.ok()) channels_.emplace(id, std::move(channel));
      unknown_.erase(id);
    }
    return part.ok() ? Result<void>() : fail("a description of messages ends within its texts");
  }

  Result<void> take_message(ByteView bytes, std::uint64_t offset, std::uint32_t chunk) {
    PartReader part(bytes);
    Place place;
    place.channel = part.get<std::uint16_t>();
    part.get<std::uint32_t>();
    place.time_ns = part.get<std::uint64_t>();
    place.offset = offset;
    place.chunk = chunk;
    if (!part.ok()) return fail("a message ends within its head");
    add(place);
    return {};
  }

  void add(const Place& place) {
    if (!channels_.contains(place.channel)) unknown_.insert(place.channel);
    places_.push_back(place);
  }

  Result<void> take_chunk(ByteView bytes, std::uint64_t begin, std::uint64_t size) {
    PartReader part(bytes);
    Chunk chunk;
    part.get<std::uint64_t>();
    part.get<std::uint64_t>();
    chunk.unpacked = part.get<std::uint64_t>();
    chunk.checksum = part.get<std::uint32_t>();
    chunk.compression = part.text();
    chunk.packed = part.get<std::uint64_t>();
    if (!part.ok()) return fail("a chunk ends within its head");
    const std::uint64_t head = bytes.size() - part.rest().size();
    if (chunk.packed > size - head) return fail("the records of a chunk end after it");
    chunk.begin = begin + head;
    if (!chunk.compression.empty() && chunk.compression != "zstd" && chunk.compression != "lz4") {
      return fail(ErrorCode::unsupported,
                  concat("a chunk is compressed by '", printable(chunk.compression),
                         "'; zstd and lz4 can be read"));
    }
    chunks_.push_back(std::move(chunk));
    return {};
  }

  /// Which messages of a channel are where in the chunk before.
  Result<void> take_index(ByteView bytes) {
    PartReader part(bytes);
    const auto channel = part.get<std::uint16_t>();
    const auto size = part.get<std::uint32_t>();
    if (!part.ok() || size > part.rest().size() || chunks_.empty())
      return fail("an index of messages ends within its entries, or belongs to no chunk");
    const auto chunk = static_cast<std::uint32_t>(chunks_.size() - 1);
    chunks_.back().indexed = true;
    PartReader entries(part.rest().subspan(0, size));
    for (std::uint32_t i = 0; i < size / 16; ++i) {
      Place place;
      place.time_ns = entries.get<std::uint64_t>();
      place.offset = entries.get<std::uint64_t>();
      place.chunk = chunk;
      place.channel = channel;
      add(place);
    }
    return {};
  }

  /// The descriptions in a chunk, and its messages if it has no index.
  Result<void> read_contents(std::uint32_t index) {
    const auto bytes = TRY(unpacked(index));
    ByteView rest = *bytes;
    std::uint64_t at = 0;
    while (rest.size() >= kHead) {
      ByteReader reader(rest);
      const auto opcode = reader.get<std::uint8_t>();
      const auto size = reader.get<std::uint64_t>();
      if (size > rest.size() - kHead) {
        if (chunks_[index].cut) return {};
        return fail(concat("chunk ", index, ": a record ends after its chunk"));
      }
      const ByteView content = rest.subspan(kHead, static_cast<std::size_t>(size));
      if (opcode == kSchema || opcode == kChannel)
        TRY(at_place(concat("chunk ", index), take_description(opcode, content)));
      if (opcode == kMessage && !chunks_[index].indexed)
        TRY(at_place(concat("chunk ", index), take_message(content, at, index)));
      rest = rest.subspan(kHead + static_cast<std::size_t>(size));
      at += kHead + size;
    }
    return {};
  }

  /// Keeps the messages of one topic.
  Result<void> choose(const std::string& topic) {
    std::map<std::string, std::size_t> clouds;  // messages by topic
    std::map<std::uint16_t, std::string> of_channel;
    std::string others;
    for (const auto& [id, channel] : channels_) {
      const auto schema = schemas_.find(channel.schema);
      const std::string kind = schema == schemas_.end() ? "" : schema->second;
      if (kind == kPointCloud2 && channel.encoding == "cdr") {
        of_channel[id] = channel.topic;
        clouds[channel.topic];
      } else if (others.size() < 200) {
        others += concat(others.empty() ? "" : ", ", printable(channel.topic), " (",
                         printable(kind), " in ", printable(channel.encoding), ")");
      }
    }
    for (const Place& place : places_) {
      if (const auto found = of_channel.find(place.channel); found != of_channel.end())
        ++clouds[found->second];
    }
    std::erase_if(clouds, [](const auto& entry) { return entry.second == 0; });
    std::string list;
    for (const auto& [name, count] : clouds) {
      if (list.size() < 400)
        list += concat(list.empty() ? "" : ", ", printable(name), " (", count, ")");
    }
    if (clouds.empty()) {
      return fail(ErrorCode::unsupported,
                  concat("has no messages ", kPointCloud2, " in cdr",
                         others.empty() ? std::string() : concat("; it has ", others)));
    }
    if (topic.empty() && clouds.size() > 1) {
      return fail(ErrorCode::argument, concat("has point clouds of ", clouds.size(),
                                              " topics: ", list, "; choose one by --topic"));
    }
    const std::string chosen = topic.empty() ? clouds.begin()->first : topic;
    if (!clouds.contains(chosen)) {
      return fail(ErrorCode::argument, concat("has no point clouds of the topic ",
                                              printable(chosen), ", but of ", list));
    }
    std::erase_if(places_, [&](const Place& place) {
      const auto found = of_channel.find(place.channel);
      return found == of_channel.end() || found->second != chosen;
    });
    std::stable_sort(places_.begin(), places_.end(),
                     [](const Place& a, const Place& b) { return a.time_ns < b.time_ns; });
    return {};
  }

  Result<Bytes> read_from_file(const Place& place, std::uint64_t end) const {
    const std::optional<Record> record = TRY(record_at(place.offset));
    const std::uint64_t begin = place.offset + kHead;
    if (!record || record->opcode != kMessage || record->size < kMessageHead ||
        record->size > end - std::min(begin, end))
      return fail("is not where the index says");
    const auto size = static_cast<std::size_t>(record->size - kMessageHead);
    Bytes room;
    const ByteView bytes = TRY(source_.view(begin + kMessageHead, size, room));
    if (bytes.size() < size) return fail("the file has become shorter");
    if (bytes.data() == room.data()) {
      room.resize(size);
      return room;
    }
    return Bytes(bytes.begin(), bytes.end());
  }

  static Result<Bytes> part_of(ByteView bytes, const Place& place) {
    const auto wrong = [] { return fail("is not where the index says"); };
    if (place.offset > bytes.size() || bytes.size() - place.offset < kHead) return wrong();
    const ByteView from = bytes.subspan(static_cast<std::size_t>(place.offset));
    ByteReader reader(from);
    const auto opcode = reader.get<std::uint8_t>();
    const auto size = reader.get<std::uint64_t>();
    if (opcode != kMessage || size < kMessageHead || size > from.size() - kHead) return wrong();
    const ByteView content =
        from.subspan(kHead + kMessageHead, static_cast<std::size_t>(size) - kMessageHead);
    return Bytes(content.begin(), content.end());
  }

  using SharedChunk = std::shared_ptr<const Bytes>;

  /// The most bytes of memory that a chunk may take.
  std::uint64_t most_of_chunk() const { return std::min(max_memory_ / kKept, kMaxChunk); }

  /// The records of a chunk. The newest few are kept, because the next message is mostly there.
  Result<SharedChunk> unpacked(std::uint32_t index) const {
    {
      const std::lock_guard lock(mutex_);
      for (auto& [kept, bytes] : kept_)
        if (kept == index) return bytes;
    }
    const Chunk& chunk = chunks_[index];
    const std::string where = concat("chunk ", index);
    const bool plain = chunk.compression.empty();
    const std::uint64_t most = most_of_chunk();
    if (std::max(chunk.packed, plain ? 0 : chunk.unpacked) > most) {
      return fail(ErrorCode::limit,
                  concat(where, ": takes ", std::max(chunk.packed, chunk.unpacked),
                         " bytes of memory, more than ", most));
    }
    auto made = or_out_of_memory([&]() -> Result<SharedChunk> {
      Bytes room;
      const ByteView packed =
          TRY(source_.view(chunk.begin, static_cast<std::size_t>(chunk.packed), room));
      if (packed.size() < chunk.packed) return fail("the file has become shorter");
      if (plain) {
        TRY(check_sum(chunk, packed));
        return std::make_shared<const Bytes>(packed.begin(), packed.end());
      }
      return std::make_shared<const Bytes>(TRY(unpack(chunk, packed)));
    });
    if (!made) return fail_at(where, made.error());
    const std::lock_guard lock(mutex_);
    kept_.emplace_back(index, *made);
    if (kept_.size() > kKept) kept_.pop_front();
    return *made;
  }

  static constexpr std::size_t kKept = 4;  ///< chunks
  static constexpr std::size_t kMostWarnings = 8;

  const ByteSource source_;
  const std::uint64_t max_memory_;
  const bool best_effort_;
  RecordingLoss loss_;
  bool lost_chunk_ = false;  ///< the newest chunk was left out
  std::map<std::uint16_t, std::string> schemas_;
  std::map<std::uint16_t, Channel> channels_;
  std::vector<Chunk> chunks_;
  std::vector<Place> places_;
  std::set<std::uint16_t> unknown_;  ///< channels of places that were not described yet
  mutable std::mutex mutex_;         // guards what follows
  mutable std::list<std::pair<std::uint32_t, SharedChunk>> kept_;
};

McapRecording::McapRecording(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
McapRecording::~McapRecording() = default;

Result<std::shared_ptr<const McapRecording>> McapRecording::open(ByteSource source,
                                                                 const std::string& topic,
                                                                 std::uint64_t max_memory,
                                                                 bool best_effort) {
  auto impl = std::make_unique<Impl>(std::move(source), max_memory, best_effort);
  TRY(or_out_of_memory([&] { return impl->open(topic); }));
  return std::shared_ptr<const McapRecording>(new McapRecording(std::move(impl)));
}

std::size_t McapRecording::size() const { return impl_->size(); }
std::optional<std::uint64_t> McapRecording::time_ns(std::size_t message) const {
  return impl_->time_ns(message);
}
RecordingLoss McapRecording::loss() const { return impl_->loss(); }
std::string McapRecording::name(std::size_t message) const { return concat("message ", message); }
Result<Bytes> McapRecording::read(std::size_t message) const { return impl_->read(message); }

}  // namespace pointreel
