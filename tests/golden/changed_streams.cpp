#include <algorithm>
#include <functional>
#include <limits>
#include <utility>

#include "common/base/try.h"
#include "tests/forge.h"
#include "tests/golden/streams.h"

namespace pointreel::golden {
namespace {

using enum ChunkKind;

// Offsets of fields: FORMAT.md, "Frame header" and "Chunk".
enum FrameField : std::size_t {
  kVersion = 4,
  kCodec = 5,
  kDepth = 6,
  kFlags = 7,
  kSource = 8,
  kPoints = 12,
  kLayers = 16,
  kTag = 20,
  kCorner = 24,
  kEdge = 48
};
enum ChunkField : std::size_t {
  kKind = 2,
  kLayer = 3,
  kChunkTag = 4,
  kLastLevel = 8,
  kRawSize = 12
};

/// A frame that is being changed.
class Forger {
 public:
  explicit Forger(EncodedFrame frame) : frame_(std::move(frame)) {}

  Bytes& part(std::size_t layer, ChunkKind kind) { return chunk_of(frame_.layers[layer], kind); }
  Bytes& header() { return part(0, geometry); }

  template <class T>
  void set(std::size_t field, T value) {
    put_at(header(), field, value);
  }
  template <class T>
  void set(std::size_t layer, ChunkKind kind, std::size_t field, T value) {
    put_at(part(layer, kind), chunk_begin(layer, kind) + field, value);
  }
  /// The offset of the payload in its chunk.
  static std::size_t payload(std::size_t layer, ChunkKind kind) {
    return chunk_begin(layer, kind) + kChunkHeaderSize;
  }
  std::size_t payload_size(std::size_t layer, ChunkKind kind) {
    return part(layer, kind).size() - payload(layer, kind);
  }
  /// Makes the payload longer or shorter; resize_raw also changes the raw size, as payloads that
  /// are stored uncompressed need.
  void resize(std::size_t layer, ChunkKind kind, std::size_t size, std::uint8_t fill = 0) {
    part(layer, kind).resize(payload(layer, kind) + size, fill);
  }
  void resize_raw(std::size_t layer, ChunkKind kind, std::size_t size, std::uint8_t fill = 0) {
    resize(layer, kind, size, fill);
    set(layer, kind, kRawSize, static_cast<std::uint32_t>(size));
  }

  EncodedFrame& frame() { return frame_; }

 private:
  EncodedFrame frame_;
};

using Change = std::function<void(Forger&)>;

class Collection {
 public:
  explicit Collection(const std::vector<Stream>& good) : good_(good) {}

  const EncodedFrame& good(const std::string& name) {
    const auto found = std::find_if(good_.begin(), good_.end(),
                                    [&](const Stream& stream) { return stream.name == name; });
    if (found != good_.end()) return found->frame;
    missing_ = name;
    return good_.front().frame;
  }

  /// A change that leaves the checksums wrong.
  void damaged(const std::string& name, const std::string& from, const Change& change,
               bool odd = false) {
    Forger forger(good(from));
    change(forger);
    streams_.push_back({(odd ? "odd_" : "bad_") + name, std::move(forger.frame())});
  }

  /// A change with correct checksums.
  void forged(const std::string& name, const std::string& from, const Change& change) {
    damaged(name, from, [&](Forger& forger) {
      change(forger);
      mend(forger.frame());
    });
  }

  /// A change with correct checksums that leaves the frame valid.
  void odd(const std::string& name, const std::string& from, const Change& change) {
    const auto mended = [&](Forger& forger) {
      change(forger);
      mend(forger.frame());
    };
    damaged(name, from, mended, true);
  }

  Result<std::vector<Stream>> finish() {
    if (!missing_.empty()) return fail("no good stream " + missing_);
    return std::move(streams_);
  }

 private:
  const std::vector<Stream>& good_;
  std::vector<Stream> streams_;
  std::string missing_;
};

/// Of "scalars_one_layer", whose fields lie in layer 1 in place of a geometry.
void add_scalars(Collection& all) {
  constexpr std::size_t kFields = 1, kStep = kFields + 1 + 8, kName = kStep + 9;
  // The entries of "height", "class" and "patchy" have 22 bytes beside the names.
  constexpr std::size_t kStreams = kFields + 3 * 22 + 6 + 5 + 6;
  const auto forged = [&](const char* name, std::size_t at, std::uint8_t value) {
    all.forged(name, "scalars_one_layer",
               [=](Forger& f) { f.part(1, geometry)[Forger::payload(1, geometry) + at] = value; });
  };
  all.damaged("scalars_damaged", "scalars_one_layer",
              [](Forger& f) { f.part(1, geometry).back() ^= 1; });
  forged("scalars_none", 0, 0);
  forged("scalars_nine", 0, 9);
  forged("scalars_flags", kFields, 4);
  forged("scalars_step_negative", kStep + 7, 0xbf);
  forged("scalars_name_empty", kName - 1, 0);
  forged("scalars_name_with_line_break", kName, 10);
  forged("scalars_lossy", kStreams + 1, 0);
  all.forged("scalars_cut", "scalars_one_layer",
             [](Forger& f) { f.resize_raw(1, geometry, f.payload_size(1, geometry) - 1); });
  all.forged("scalars_bytes_behind", "scalars_one_layer",
             [](Forger& f) { f.resize_raw(1, geometry, f.payload_size(1, geometry) + 1); });
  all.forged("scalars_of_another_frame", "scalars_one_layer",
             [](Forger& f) { f.set(1, geometry, kChunkTag, std::uint32_t{7}); });
  all.forged("scalars_of_another_layer", "scalars_one_layer",
             [](Forger& f) { f.set(1, geometry, kLayer, std::uint8_t{2}); });
  all.forged("scalars_are_geometry", "scalars_one_layer",
             [](Forger& f) { f.set(1, geometry, kKind, std::uint8_t{0}); });
}

void add_headers(Collection& all) {
  const auto truncated = [&](const char* name, std::size_t size) {
    all.damaged(name, "zstd_one_layer", [size](Forger& f) { f.header().resize(size); });
  };
  truncated("nothing", 0);
  truncated("header_cut", 63);
  truncated("header_alone", 64);
  truncated("chunk_header_cut", 87);
  truncated("payload_cut", 100);
  all.damaged("header_damaged", "zstd_one_layer", [](Forger& f) { f.header()[kEdge] ^= 1; });
  all.damaged("header_checksum", "zstd_one_layer", [](Forger& f) { f.header()[63] ^= 1; });
  all.damaged("chunk_header_damaged", "zstd_one_layer",
              [](Forger& f) { f.header()[64 + kRawSize] ^= 1; });
  all.damaged("payload_damaged", "zstd_one_layer", [](Forger& f) { f.header().back() ^= 0x80; });
  all.damaged("bytes_behind_chunk", "zstd_one_layer", [](Forger& f) { f.header().push_back(0); });

  const auto header = [&](const char* name, std::size_t field, auto value) {
    all.forged(name, "zstd_lossless", [=](Forger& f) { f.set(field, value); });
  };
  header("magic", 0, std::uint8_t{'p'});
  header("version_0", kVersion, std::uint8_t{0});
  header("version_1", kVersion, std::uint8_t{1});
  header("version_3", kVersion, std::uint8_t{3});
  header("codec_0", kCodec, std::uint8_t{0});
  header("codec_3", kCodec, std::uint8_t{3});
  header("codec_of_another", kCodec, std::uint8_t{2});
  header("depth_22", kDepth, std::uint8_t{22});
  header("depth_less", kDepth, std::uint8_t{9});
  header("depth_more", kDepth, std::uint8_t{11});
  header("flag_unknown", kFlags, std::uint8_t{0x83});
  header("flags_16_bits_transformed", kFlags, std::uint8_t{1 | 2 | 4 | 8});
  header("flags_transformed_no_colors", kFlags, std::uint8_t{2 | 8});
  header("flags_transformed_no_normals", kFlags, std::uint8_t{1 | 16});
  header("flags_16_bits", kFlags, std::uint8_t{1 | 2 | 4});
  header("points_more_than_given", kSource, std::uint32_t{5});
  header("points_fewer", kPoints, std::uint32_t{7});
  header("layers_0", kLayers, std::uint32_t{0});
  header("layers_fewer", kLayers, std::uint32_t{2});
  header("layers_more", kLayers, std::uint32_t{4});
  header("layers_huge", kLayers, ~std::uint32_t{0});
  header("tag_of_another", kTag, std::uint32_t{12345});
  header("corner_infinite", kCorner + 8, std::numeric_limits<double>::infinity());
  header("corner_no_number", kCorner, std::numeric_limits<double>::quiet_NaN());
  header("edge_0", kEdge, 0.0);
  header("edge_negative", kEdge, -2.0);
  header("edge_tiny", kEdge, 1e-31);
  header("edge_huge", kEdge, 1e31);
  header("edge_no_number", kEdge, std::numeric_limits<double>::quiet_NaN());
  all.forged("points_too_many", "zstd_lossless", [](Forger& f) {
    f.set(kSource, ~std::uint32_t{0});
    f.set(kPoints, ~std::uint32_t{0});
  });
  all.forged("points_one_more", "zstd_lossless", [](Forger& f) {
    const auto points = f.frame().coded_points + 1;
    f.set(kSource, points);
    f.set(kPoints, points);
  });
  all.forged("empty_with_depth", "none_empty", [](Forger& f) { f.set(kDepth, std::uint8_t{3}); });
  all.forged("empty_with_mask", "none_empty", [](Forger& f) { f.resize_raw(0, geometry, 1, 1); });
}

void add_chunks(Collection& all) {
  const auto chunk = [&](const char* name, std::size_t field, auto value) {
    all.forged(name, "zstd_three_layers", [=](Forger& f) { f.set(1, geometry, field, value); });
  };
  chunk("chunk_magic", 0, std::uint8_t{'r'});
  chunk("chunk_of_colors", kKind, std::uint8_t{0x11});
  chunk("chunk_of_kind_3", kKind, std::uint8_t{0x13});
  chunk("chunk_coding_3", kKind, std::uint8_t{0x30});
  chunk("chunk_of_other_layer", kLayer, std::uint8_t{2});
  chunk("chunk_of_other_frame", kChunkTag, std::uint32_t{12345});
  chunk("chunk_level_22", kLastLevel, std::uint32_t{22});
  chunk("chunk_level_other", kLastLevel, std::uint32_t{8});
  chunk("chunk_size_less", kRawSize, std::uint32_t{1});
  chunk("chunk_size_huge", kRawSize, ~std::uint32_t{0});
  all.damaged("layers_swapped", "zstd_three_layers",
              [](Forger& f) { std::swap(f.frame().layers[1], f.frame().layers[2]); });
  all.damaged("parts_swapped", "zstd_three_layers",
              [](Forger& f) { std::swap(f.part(1, colors), f.part(1, normals)); });
  const EncodedFrame& other = all.good("zstd_lossless");
  all.damaged("layer_of_other_frame", "zstd_three_layers",
              [&](Forger& f) { f.part(1, geometry) = other.layers[1].geometry; });
  all.damaged("colors_of_other_frame", "zstd_three_layers",
              [&](Forger& f) { f.part(1, colors) = other.layers[1].colors; });
}

void add_masks(Collection& all) {
  const auto masks = [&](const char* name, const Change& change) {
    all.forged(name, "none_one_layer", change);
  };
  const std::size_t begin = Forger::payload(0, geometry);
  masks("mask_0", [=](Forger& f) { f.header()[begin + 1] = 0; });
  masks("mask_more_children", [=](Forger& f) { f.header()[begin + 1] = 0xff; });
  masks("mask_fewer_children", [=](Forger& f) { f.header()[begin] = 1; });
  masks("mask_last_other", [](Forger& f) { f.header().back() = 0xff; });
  masks("masks_missing",
        [](Forger& f) { f.resize_raw(0, geometry, f.payload_size(0, geometry) - 1); });
  masks("masks_too_many",
        [](Forger& f) { f.resize_raw(0, geometry, f.payload_size(0, geometry) + 1, 1); });
  masks("masks_of_wrong_size",
        [](Forger& f) { f.resize(0, geometry, f.payload_size(0, geometry) + 1, 1); });
  masks("masks_none", [](Forger& f) { f.resize_raw(0, geometry, 0); });
  masks("masks_as_zstd", [](Forger& f) { f.set(0, geometry, kKind, std::uint8_t{0x10}); });
  masks("masks_as_context", [](Forger& f) { f.set(0, geometry, kKind, std::uint8_t{0x20}); });
  const auto zstd = [&](const char* name, const Change& change) {
    all.forged(name, "zstd_dense", change);
  };
  zstd("zstd_cut", [](Forger& f) { f.resize(0, geometry, f.payload_size(0, geometry) - 1); });
  zstd("zstd_goes_on", [](Forger& f) { f.resize(0, geometry, f.payload_size(0, geometry) + 1); });
  zstd("zstd_magic", [=](Forger& f) { f.header()[begin] ^= 1; });
  zstd("zstd_damaged", [=](Forger& f) { f.header()[begin + 20] ^= 0xff; });
  zstd("zstd_larger", [](Forger& f) { f.set(0, geometry, kRawSize, std::uint32_t{3000}); });
  zstd("zstd_as_none", [](Forger& f) { f.set(0, geometry, kKind, std::uint8_t{0}); });
}

void add_contexts(Collection& all) {
  const std::size_t begin = Forger::payload(0, geometry);
  const auto one = [&](const char* name, const Change& change) {
    all.forged(name, "context_one_layer", change);
  };
  const auto three = [&](const char* name, const Change& change) {
    all.forged(name, "context_three_layers", change);
  };
  one("context_payload_none", [](Forger& f) { f.resize(0, geometry, 0); });
  one("context_tables_0", [=](Forger& f) { f.header()[begin] = 0; });
  one("context_tables_77", [=](Forger& f) { f.header()[begin] = 77; });
  one("context_tables_of_its_own", [=](Forger& f) { f.header()[begin] = 255; });
  one("context_classes_cut", [](Forger& f) { f.resize(0, geometry, 4); });
  one("context_class_6", [=](Forger& f) { f.header()[begin + 3] = 6; });
  one("context_class_other", [=](Forger& f) { f.header()[begin + 6] ^= 1; });
  one("context_masks_0", [](Forger& f) { f.set(0, geometry, kRawSize, std::uint32_t{0}); });
  one("context_masks_fewer", [](Forger& f) { f.set(0, geometry, kRawSize, std::uint32_t{99}); });
  one("context_masks_more", [](Forger& f) { f.set(0, geometry, kRawSize, std::uint32_t{500}); });
  one("context_masks_huge", [](Forger& f) { f.set(0, geometry, kRawSize, ~std::uint32_t{0}); });
  one("context_bytes_cut",
      [](Forger& f) { f.resize(0, geometry, f.payload_size(0, geometry) - 1); });
  one("context_bytes_half",
      [](Forger& f) { f.resize(0, geometry, f.payload_size(0, geometry) / 2); });
  one("context_bytes_behind",
      [](Forger& f) { f.resize(0, geometry, f.payload_size(0, geometry) + 1, 1); });
  one("context_first_byte", [=](Forger& f) { f.header()[begin + 7] ^= 0x80; });
  one("context_middle_byte",
      [=](Forger& f) { f.header()[begin + f.payload_size(0, geometry) / 2] ^= 1; });
  three("context_second_layer",
        [](Forger& f) { f.part(1, geometry)[Forger::payload(1, geometry) + 10] ^= 0x10; });
  three("context_then_none", [](Forger& f) { f.set(1, geometry, kKind, std::uint8_t{0}); });
  all.forged("none_then_context", "none_three_layers",
             [](Forger& f) { f.set(1, geometry, kKind, std::uint8_t{0x20}); });
}

void add_slabs(Collection& all) {
  // The second layer has one level, so its payload begins with: class, number of slabs, and where
  // all slabs but the first begin.
  const std::size_t begin = Forger::payload(1, geometry), count = begin + 1, cuts = begin + 2;
  const auto slabs = [&](const char* name, const Change& change) {
    all.forged(std::string("slabs_") + name, "slabs", change);
  };
  const auto byte = [&](const char* name, std::size_t at, std::uint8_t value) {
    slabs(name, [=](Forger& f) { f.part(1, geometry)[at] = value; });
  };
  byte("number_0", count, 0);
  byte("number_1", count, 1);
  byte("number_17", count, 17);
  slabs("begin_0", [=](Forger& f) { put_at(f.part(1, geometry), cuts, std::uint16_t{0}); });
  slabs("begin_far", [=](Forger& f) { put_at(f.part(1, geometry), cuts, std::uint16_t{65535}); });
  slabs("size_huge", [=](Forger& f) {
    Bytes& part = f.part(1, geometry);
    put_at(part, cuts + 2 * (part[count] - std::size_t{1}), ~std::uint32_t{0});
  });
  slabs("size_other", [=](Forger& f) {
    Bytes& part = f.part(1, geometry);
    part[cuts + 2 * (part[count] - std::size_t{1})] ^= 4;
  });
  slabs("header_cut", [=](Forger& f) { f.resize(1, geometry, 4); });
  slabs("damaged",
        [=](Forger& f) { f.part(1, geometry)[begin + f.payload_size(1, geometry) / 2] ^= 1; });
  all.forged("slabs_in_base", "context_one_layer",
             [](Forger& f) { f.header()[Forger::payload(0, geometry) + 7] = 2; });
}

void add_attributes(Collection& all) {
  const std::size_t begin = Forger::payload(1, colors);
  const auto exact = [&](const char* name, const Change& change) {
    all.forged(name, "none_lossless", change);
  };
  exact("colors_cut", [](Forger& f) { f.resize_raw(1, colors, f.payload_size(1, colors) - 1); });
  exact("colors_too_many",
        [](Forger& f) { f.resize_raw(1, colors, f.payload_size(1, colors) + 3); });
  exact("colors_as_context", [](Forger& f) { f.set(1, colors, kKind, std::uint8_t{0x21}); });
  exact("colors_other_level", [](Forger& f) { f.set(1, colors, kLastLevel, std::uint32_t{8}); });
  exact("normals_none", [](Forger& f) { f.resize_raw(0, normals, 0); });
  exact("normals_as_zstd", [](Forger& f) { f.set(0, normals, kKind, std::uint8_t{0x12}); });
  const auto lossy = [&](const char* name, const Change& change) {
    all.forged(name, "context_three_layers", change);
  };
  lossy("lossy_flag", [=](Forger& f) { f.part(1, colors)[begin + 1] |= 0x80; });
  lossy("level_behind_layer_predicted", [=](Forger& f) { f.part(1, colors)[begin] |= 4; });
  lossy("root_predicted", [=](Forger& f) { f.part(0, normals)[Forger::payload(0, normals)] |= 1; });
  const auto turn_exact = [=](Forger& f, ChunkKind kind) {
    for (std::size_t layer = 0; layer < 3; ++layer) {
      f.part(layer, kind)[Forger::payload(layer, kind) + 1] |= 0x80;
    }
  };
  lossy("exact_normals", [=](Forger& f) { turn_exact(f, normals); });
  all.forged("exact_colors_of_16_bits", "colors_of_16_bits_lossy",
             [=](Forger& f) { turn_exact(f, colors); });
  all.forged("exact_not_everywhere", "context_lossless",
             [=](Forger& f) { f.part(2, colors)[begin + 1] ^= 0x80; });
  lossy("lossy_luma_step_0",
        [=](Forger& f) { f.set(1, colors, kChunkHeaderSize + 2, std::uint16_t{0}); });
  lossy("lossy_chroma_step_0",
        [=](Forger& f) { f.set(1, normals, kChunkHeaderSize + 4, std::uint16_t{0}); });
  lossy("lossy_header_cut", [](Forger& f) { f.resize_raw(1, colors, 4); });
  lossy("lossy_root_cut", [](Forger& f) { f.resize_raw(0, colors, 8); });
  lossy("lossy_coded_none", [](Forger& f) { f.resize_raw(1, colors, 6); });
  lossy("lossy_zeros_behind",
        [](Forger& f) { f.resize_raw(1, colors, f.payload_size(1, colors) + 1); });
  lossy("lossy_cut", [](Forger& f) { f.resize_raw(1, colors, f.payload_size(1, colors) - 1); });
  lossy("lossy_goes_on",
        [](Forger& f) { f.resize_raw(1, normals, f.payload_size(1, normals) + 1, 0xff); });
  lossy("lossy_size_other", [](Forger& f) { f.resize(1, colors, f.payload_size(1, colors) + 1); });
  lossy("lossy_as_zstd", [](Forger& f) { f.set(1, colors, kKind, std::uint8_t{0x11}); });
  lossy("lossy_other_level", [](Forger& f) { f.set(1, normals, kLastLevel, std::uint32_t{8}); });
  lossy("lossy_called_exact", [](Forger& f) { f.set(kFlags, std::uint8_t{1 | 2}); });
}

void add_draco(Collection& all) {
  const std::size_t begin = Forger::payload(0, geometry);
  const auto draco = [&](const char* name, const Change& change) {
    all.forged("draco_" + std::string(name), "draco_level_10", change);
  };
  draco("payload_cut",
        [](Forger& f) { f.resize_raw(0, geometry, f.payload_size(0, geometry) / 2); });
  draco("payload_none", [](Forger& f) { f.resize_raw(0, geometry, 0); });
  all.forged("draco_sequential_cut", "draco_sequential_10",
             [](Forger& f) { f.resize_raw(0, geometry, f.payload_size(0, geometry) - 20); });
  all.forged("draco_sequential_damaged", "draco_sequential_10",
             [=](Forger& f) { f.header()[begin + 40] ^= 0xff; });
  draco("magic", [=](Forger& f) { f.header()[begin] = 'd'; });
  draco("version", [=](Forger& f) { f.header()[begin + 5] = 9; });
  draco("mesh", [=](Forger& f) { f.header()[begin + 7] = 1; });
  draco("points_huge", [=](Forger& f) { put_at(f.header(), begin + 11, 0x7fffffff); });
  draco("points_other", [](Forger& f) {
    f.set(kSource, f.frame().coded_points + 1);
    f.set(kPoints, f.frame().coded_points + 1);
  });
  draco("points_fewer_than_given", [](Forger& f) { f.set(kSource, f.frame().coded_points + 1); });
  draco("no_normals", [](Forger& f) { f.set(kFlags, std::uint8_t{1}); });
  draco("no_colors", [](Forger& f) { f.set(kFlags, std::uint8_t{2}); });
  draco("layers_2", [](Forger& f) { f.set(kLayers, std::uint32_t{2}); });
  draco("depth_0", [](Forger& f) { f.set(kDepth, std::uint8_t{0}); });
  draco("level", [](Forger& f) { f.set(0, geometry, kLastLevel, std::uint32_t{7}); });
  draco("as_zstd", [](Forger& f) { f.set(0, geometry, kKind, std::uint8_t{0x10}); });
  draco("called_octree", [](Forger& f) { f.set(kCodec, std::uint8_t{1}); });
}

/// Frames that our encoders do not make but every decoder must read.
void add_odd(Collection& all) {
  all.odd("zeros_behind_context", "context_three_layers", [](Forger& f) {
    f.resize(0, geometry, f.payload_size(0, geometry) + 3);
    f.resize(2, geometry, f.payload_size(2, geometry) + 100);
  });
  for (const std::string from : {"none_lossless", "context_three_layers", "context_lossless"}) {
    all.odd("no_base_colors_" + from, from, [](Forger& f) { f.part(0, colors).clear(); });
    all.odd("no_middle_colors_" + from, from, [](Forger& f) { f.part(1, colors).clear(); });
    all.odd("no_full_normals_" + from, from, [](Forger& f) { f.part(2, normals).clear(); });
  }
  const EncodedFrame& none = all.good("none_three_layers");
  all.odd("zstd_then_none", "zstd_three_layers",
          [&](Forger& f) { f.part(2, geometry) = none.layers[2].geometry; });
  all.odd("more_points_given", "context_one_layer",
          [](Forger& f) { f.set(kSource, ~std::uint32_t{0}); });
  all.odd("corner_far_away", "context_one_layer", [](Forger& f) { f.set(kCorner, -1e300); });
  all.odd("edge_small", "context_one_layer", [](Forger& f) { f.set(kEdge, 1e-30); });
}

}  // namespace

Result<std::vector<Stream>> changed_streams() {
  const std::vector<Stream> good = TRY(good_streams());
  Collection all(good);
  add_headers(all);
  add_scalars(all);
  add_chunks(all);
  add_masks(all);
  add_contexts(all);
  add_slabs(all);
  add_attributes(all);
  add_draco(all);
  add_odd(all);
  return all.finish();
}

}  // namespace pointreel::golden
