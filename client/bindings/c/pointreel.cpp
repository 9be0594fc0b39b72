#include "client/bindings/c/pointreel.h"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "client/bindings/c/border.h"
#include "client/bindings/c/handles.h"
#include "client/bindings/frames/encoded_bytes.h"
#include "client/bindings/frames/encoding_choice.h"
#include "client/bindings/frames/point_arrays.h"
#include "client/bindings/frames/reel_frames.h"
#include "client/source/open_live_source.h"
#include "client/source/open_source.h"
#include "codec/package/manifest.h"
#include "codec/segments/package_writer.h"
#include "common/base/concat.h"
#include "common/base/try.h"
#include "pointreel/version.h"

namespace pointreel {
namespace {

/// The letter of an axis, in capitals if it points down.
char letter_of(Up up) {
  const auto letter = static_cast<char>('x' + up.axis());
  return up.reversed() ? static_cast<char>(letter - 'x' + 'X') : letter;
}
Result<Up> up_of(char letter) {
  for (const char axis : {'x', 'y', 'z'})
    for (const Up up : {Up(axis), Up(axis, true)})
      if (letter_of(up) == letter) return up;
  return fail(ErrorCode::argument, "the axis that points up is none of x, y, z, X, Y and Z");
}

struct Live {
  std::mutex mutex;  ///< one call takes a frame at a time
  std::unique_ptr<LiveSource> source;
  std::stop_token stop;
  std::optional<std::stop_callback<std::function<void()>>> on_stop;
};

struct Writer {
  std::mutex mutex;  ///< one call writes at a time
  PackageWriter package;
  std::stop_token stop;
};

// Never destroyed: threads may still use them while the process ends.
auto& cancellers() {
  static auto& handles = *new Handles<pointreel_canceller, std::stop_source>;
  return handles;
}
auto& frames() {
  static auto& handles = *new Handles<pointreel_frame, const PointFrame>;
  return handles;
}
auto& reels() {
  static auto& handles = *new Handles<pointreel_reel, const ReelFrames>;
  return handles;
}
auto& lives() {
  static auto& handles = *new Handles<pointreel_live, Live>;
  return handles;
}
auto& encoded() {
  static auto& handles = *new Handles<pointreel_bytes, const Bytes>;
  return handles;
}
auto& writers() {
  static auto& handles = *new Handles<pointreel_writer, Writer>;
  return handles;
}

/// Sets what a function gives to NULL until it is known. An error if there is no place for it.
template <class Handle>
Result<void> clear(Handle** place) {
  if (place == nullptr) return fail(ErrorCode::argument, "the place for the result is NULL");
  *place = nullptr;
  return {};
}

Result<std::stop_token> stop_of(const pointreel_canceller* canceller) {
  if (canceller == nullptr) return std::stop_token();
  return TRY(cancellers().get(canceller, "the canceller"))->get_token();
}

Result<std::string> text_of(const char* text, const char* what) {
  if (text == nullptr) return fail(ErrorCode::argument, std::string(what) + " is NULL");
  return std::string(text);
}

std::string text_or_nothing(const char* text) { return text == nullptr ? "" : text; }

Result<ReadLimits> limits_of(const pointreel_read_options* given) {
  const pointreel_read_options options = TRY(options_of(given, "pointreel_read_options"));
  ReadLimits limits;
  if (options.layers != 0) limits.layers = options.layers;
  if (options.max_memory != 0) limits.max_memory = options.max_memory;
  limits.stop = TRY(stop_of(options.canceller));
  return limits;
}

Result<SourceOptions> source_options_of(const pointreel_open_options* given) {
  const pointreel_open_options options = TRY(options_of(given, "pointreel_open_options"));
  SourceOptions source;
  if (options.fps != 0.0) source.fps = options.fps;
  if (source.fps && !is_frame_rate(*source.fps))
    return fail(ErrorCode::argument, "fps is out of range");
  source.token = text_or_nothing(options.token);
  source.ca_file = text_or_nothing(options.ca_file);
  source.follow_redirects = options.follow_redirects != 0;
  source.stop = TRY(stop_of(options.canceller));
  return source;
}

Result<PointCloud> cloud_of(const pointreel_points* given) {
  if (given == nullptr) return fail(ErrorCode::argument, "the points are NULL");
  const pointreel_points points = TRY(options_of(given, "pointreel_points"));
  PointArrays arrays;
  arrays.count = points.count;
  arrays.positions = points.positions;
  arrays.world_positions = points.world_positions;
  arrays.origin = {points.origin[0], points.origin[1], points.origin[2]};
  arrays.colors_8 = points.colors_8;
  arrays.colors_16 = points.colors_16;
  arrays.normals = points.normals;
  if (points.scalars == nullptr && points.scalar_count > 0)
    return fail(ErrorCode::argument, "the scalar fields are NULL");
  if (points.scalar_count > kMaxScalars)
    return fail(ErrorCode::argument, concat("there are more than ", kMaxScalars, " scalar fields"));
  for (std::size_t i = 0; i < points.scalar_count; ++i)
    arrays.scalars.push_back({TRY(text_of(points.scalars[i].name, "the name of a scalar field")),
                              points.scalars[i].values});
  return cloud_of(arrays);
}

Result<EncodingOptions> encoding_of(const pointreel_encode_options* given) {
  const pointreel_encode_options options = TRY(options_of(given, "pointreel_encode_options"));
  if (options.codec != POINTREEL_OCTREE && options.codec != POINTREEL_DRACO)
    return fail(ErrorCode::argument, concat("there is no codec ", options.codec));
  EncodingChoice choice;
  choice.codec = options.codec == POINTREEL_DRACO ? Codec::draco : Codec::octree;
  choice.depth = options.depth;
  choice.voxel = options.voxel;
  choice.color_quality = options.color_quality;
  choice.normal_quality = options.normal_quality;
  choice.fast = options.fast != 0;
  return encoding_of(choice);
}

/// Copies one attribute, by `copy`, to the caller's room for it.
template <class Number, class Has, class Copy>
pointreel_status give_values(const pointreel_frame* handle, const Has& has, Number* values,
                             std::size_t capacity, std::size_t* count, const Copy& copy) {
  return guarded([&]() -> Result<void> {
    if (count != nullptr) *count = 0;
    const auto frame = TRY(frames().get(handle, "the frame"));
    const PointCloud& cloud = frame->cloud;
    if (!has(cloud)) return fail(ErrorCode::not_found, "the frame does not have the attribute");
    if (count != nullptr) *count = cloud.size();
    if (values == nullptr && capacity == 0) {
      if (count == nullptr) return fail(ErrorCode::argument, "neither room nor count is given");
      return {};
    }
    if (values == nullptr) return fail(ErrorCode::argument, "the room for the values is NULL");
    if (capacity < cloud.size())
      return fail(ErrorCode::limit,
                  concat("there are ", cloud.size(), " points, and room for ", capacity));
    copy(cloud, values);
    return {};
  });
}

/// Copies vectors as they are.
template <class Vector, class Number>
void copy_all(const std::vector<Vector>& vectors, Number* to) {
  static_assert(sizeof(Vector) == 3 * sizeof(Number));
  if (!vectors.empty()) std::memcpy(to, vectors.data(), vectors.size() * sizeof(Vector));
}

/// Copies the three numbers that `value` gives for each point.
template <class Number, class Value>
void copy_each(const PointCloud& cloud, Number* to, const Value& value) {
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const auto v = value(i);
    for (int axis = 0; axis < 3; ++axis) *to++ = v[axis];
  }
}

/// Null if there is no such frame or field.
const ScalarField* find_scalar(const PointCloud& cloud, std::string_view name) {
  for (const ScalarField& field : cloud.scalars)
    if (field.name == name) return &field;
  return nullptr;
}

bool always(const PointCloud&) { return true; }
bool has_colors(const PointCloud& cloud) { return cloud.has_colors(); }
bool has_normals(const PointCloud& cloud) { return cloud.has_normals(); }

Result<void> give_frame(Result<SharedFrame> frame, pointreel_frame** place) {
  *place = frames().add(TRY(std::move(frame)));
  return {};
}

}  // namespace
}  // namespace pointreel

using namespace pointreel;

const char* pointreel_version(void) { return POINTREEL_VERSION; }

// --- Cancelling ----------------------------------------------------------------------------------

pointreel_status pointreel_canceller_create(pointreel_canceller** canceller) {
  return guarded([&]() -> Result<void> {
    TRY(clear(canceller));
    *canceller = cancellers().add(std::make_shared<std::stop_source>());
    return {};
  });
}

pointreel_status pointreel_cancel(pointreel_canceller* canceller) {
  return guarded([&]() -> Result<void> {
    TRY(cancellers().get(canceller, "the canceller"))->request_stop();
    return {};
  });
}

void pointreel_canceller_close(pointreel_canceller* canceller) { cancellers().close(canceller); }

// --- Frames --------------------------------------------------------------------------------------

pointreel_status pointreel_frame_get_info(const pointreel_frame* handle,
                                          pointreel_frame_info* info) {
  return guarded([&]() -> Result<void> {
    const auto frame = TRY(frames().get(handle, "the frame"));
    pointreel_frame_info result{};
    result.points = frame->cloud.size();
    result.index = frame->info.index;
    result.layers = frame->layers;
    result.time_us = frame->info.time_us;
    for (int axis = 0; axis < 3; ++axis) result.origin[axis] = frame->cloud.origin[axis];
    result.has_colors = frame->cloud.has_colors();
    result.has_normals = frame->cloud.has_normals();
    return give(result, info, "pointreel_frame_info");
  });
}

pointreel_status pointreel_frame_get_positions(const pointreel_frame* frame, float* values,
                                               size_t capacity, size_t* count) {
  return give_values(frame, always, values, capacity, count,
                     [](const PointCloud& cloud, float* to) { copy_all(cloud.positions, to); });
}

pointreel_status pointreel_frame_get_world_positions(const pointreel_frame* frame, double* values,
                                                     size_t capacity, size_t* count) {
  return give_values(frame, always, values, capacity, count,
                     [](const PointCloud& cloud, double* to) {
                       copy_each(cloud, to, [&](std::size_t i) { return cloud.world(i); });
                     });
}

pointreel_status pointreel_frame_get_colors_8(const pointreel_frame* frame, uint8_t* values,
                                              size_t capacity, size_t* count) {
  return give_values(
      frame, has_colors, values, capacity, count, [](const PointCloud& cloud, uint8_t* to) {
        copy_each(cloud, to, [&](std::size_t i) { return to_8_bits(cloud.colors[i]); });
      });
}

pointreel_status pointreel_frame_get_colors_16(const pointreel_frame* frame, uint16_t* values,
                                               size_t capacity, size_t* count) {
  return give_values(frame, has_colors, values, capacity, count,
                     [](const PointCloud& cloud, uint16_t* to) { copy_all(cloud.colors, to); });
}

pointreel_status pointreel_frame_get_normals(const pointreel_frame* frame, float* values,
                                             size_t capacity, size_t* count) {
  return give_values(frame, has_normals, values, capacity, count,
                     [](const PointCloud& cloud, float* to) { copy_all(cloud.normals, to); });
}

const char* pointreel_frame_scalar_name(const pointreel_frame* handle, size_t number) {
  const auto frame = frames().find(handle);
  return frame && number < frame->cloud.scalars.size() ? frame->cloud.scalars[number].name.c_str()
                                                       : nullptr;
}

pointreel_status pointreel_frame_get_scalar(const pointreel_frame* frame, const char* name,
                                            float* values, size_t capacity, size_t* count) {
  const std::string wanted = text_or_nothing(name);
  return give_values(
      frame, [&](const PointCloud& cloud) { return find_scalar(cloud, wanted) != nullptr; }, values,
      capacity, count,
      [&](const PointCloud& cloud, float* to) {
        const std::vector<float>& from = find_scalar(cloud, wanted)->values;
        std::copy(from.begin(), from.end(), to);
      });
}

const float* pointreel_frame_positions(const pointreel_frame* handle) {
  const auto frame = frames().find(handle);
  return frame && !frame->cloud.empty() ? &frame->cloud.positions[0].x : nullptr;
}

const uint16_t* pointreel_frame_colors(const pointreel_frame* handle) {
  const auto frame = frames().find(handle);
  return frame && frame->cloud.has_colors() ? &frame->cloud.colors[0].x : nullptr;
}

const float* pointreel_frame_normals(const pointreel_frame* handle) {
  const auto frame = frames().find(handle);
  return frame && frame->cloud.has_normals() ? &frame->cloud.normals[0].x : nullptr;
}

const float* pointreel_frame_scalar(const pointreel_frame* handle, const char* name) {
  const auto frame = frames().find(handle);
  const ScalarField* const field =
      frame && name != nullptr ? find_scalar(frame->cloud, name) : nullptr;
  return field != nullptr && !field->values.empty() ? field->values.data() : nullptr;
}

void pointreel_frame_close(pointreel_frame* frame) { frames().close(frame); }

// --- Reels ---------------------------------------------------------------------------------------

pointreel_status pointreel_reel_open(const char* where, const pointreel_open_options* options,
                                     pointreel_reel** reel) {
  return guarded([&]() -> Result<void> {
    TRY(clear(reel));
    auto source =
        TRY(open_source(TRY(text_of(where, "the reel's place")), TRY(source_options_of(options))));
    *reel = reels().add(std::make_shared<const ReelFrames>(std::move(source)));
    return {};
  });
}

pointreel_status pointreel_reel_get_info(const pointreel_reel* handle, pointreel_reel_info* info) {
  return guarded([&]() -> Result<void> {
    const auto reel = TRY(reels().get(handle, "the reel"));
    const Manifest& manifest = reel->manifest();
    pointreel_reel_info result{};
    result.frames = reel->size();
    result.layers = static_cast<std::uint32_t>(manifest.layer_names.size());
    result.fps = manifest.fps;
    result.duration_us = manifest.duration_us;
    for (int axis = 0; axis < 3; ++axis) {
      result.bounds_min[axis] = manifest.bounds.min[axis];
      result.bounds_max[axis] = manifest.bounds.max[axis];
    }
    result.has_colors = manifest.colors;
    result.has_normals = manifest.normals;
    result.up = letter_of(manifest.up);
    return give(result, info, "pointreel_reel_info");
  });
}

pointreel_status pointreel_reel_get_metadata(const pointreel_reel* handle, char* text,
                                             size_t capacity, size_t* length) {
  return guarded([&]() -> Result<void> {
    const auto reel = TRY(reels().get(handle, "the reel"));
    return give_text(write_manifest(reel->manifest()), text, capacity, length);
  });
}

pointreel_status pointreel_reel_get_frame_time(const pointreel_reel* handle, uint32_t index,
                                               uint64_t* time_us) {
  return guarded([&]() -> Result<void> {
    if (time_us == nullptr) return fail(ErrorCode::argument, "the place for the time is NULL");
    *time_us = 0;
    const auto reel = TRY(reels().get(handle, "the reel"));
    *time_us = TRY(reel->time_us(index));
    return {};
  });
}

pointreel_status pointreel_reel_get_trouble(const pointreel_reel* handle, char* text,
                                            size_t capacity, size_t* length) {
  return guarded([&]() -> Result<void> {
    const auto reel = TRY(reels().get(handle, "the reel"));
    return give_text(reel->source().trouble().value_or(""), text, capacity, length);
  });
}

pointreel_status pointreel_reel_read(pointreel_reel* handle, uint32_t index,
                                     const pointreel_read_options* options,
                                     pointreel_frame** frame) {
  return guarded([&]() -> Result<void> {
    TRY(clear(frame));
    const auto reel = TRY(reels().get(handle, "the reel"));
    return give_frame(reel->read(index, TRY(limits_of(options))), frame);
  });
}

void pointreel_reel_close(pointreel_reel* reel) { reels().close(reel); }

// --- Live streams --------------------------------------------------------------------------------

pointreel_status pointreel_live_open(const char* url, const pointreel_open_options* options,
                                     pointreel_live** handle) {
  return guarded([&]() -> Result<void> {
    TRY(clear(handle));
    const SourceOptions source = TRY(source_options_of(options));
    auto live = std::make_shared<Live>();
    live->source = TRY(open_live_source(TRY(text_of(url, "the stream's address")), source));
    live->stop = source.stop;
    live->on_stop.emplace(source.stop, [&waiting = *live->source] { waiting.cancel(); });
    *handle = lives().add(std::move(live));
    return {};
  });
}

pointreel_status pointreel_live_next(pointreel_live* handle, uint32_t timeout_ms,
                                     const pointreel_read_options* options,
                                     pointreel_frame** frame) {
  return guarded([&]() -> Result<pointreel_status> {
    TRY(clear(frame));
    const auto live = TRY(lives().get(handle, "the stream"));
    const ReadLimits limits = TRY(limits_of(options));
    const std::lock_guard lock(live->mutex);
    auto next = live->source->next(std::chrono::milliseconds(timeout_ms));
    if (live->stop.stop_requested() || limits.stop.stop_requested())
      return fail(ErrorCode::cancelled, "waiting for a frame was cancelled");
    if (!next && live->source->refusal()) return tl::unexpected(*live->source->refusal());
    if (!next) return failed(POINTREEL_TIMEOUT, "no frame has come by then");
    TRY(give_frame(decode_live(std::move(*next), limits), frame));
    return POINTREEL_OK;
  });
}

pointreel_status pointreel_live_get_trouble(const pointreel_live* handle, char* text,
                                            size_t capacity, size_t* length) {
  return guarded([&]() -> Result<void> {
    const auto live = TRY(lives().get(handle, "the stream"));
    return give_text(live->source->trouble().value_or(""), text, capacity, length);
  });
}

void pointreel_live_close(pointreel_live* live) { lives().close(live); }

// --- Encoding ------------------------------------------------------------------------------------

pointreel_status pointreel_encode(const pointreel_points* points,
                                  const pointreel_encode_options* options,
                                  pointreel_bytes** bytes) {
  return guarded([&]() -> Result<void> {
    TRY(clear(bytes));
    const EncodingOptions encoding = TRY(encoding_of(options));
    const EncodedFrame frame = TRY(encode_points(TRY(cloud_of(points)), encoding));
    *bytes = encoded().add(std::make_shared<const Bytes>(TRY(frame_bytes(frame))));
    return {};
  });
}

const uint8_t* pointreel_bytes_data(const pointreel_bytes* handle) {
  const auto bytes = encoded().find(handle);
  return bytes ? bytes->data() : nullptr;
}

size_t pointreel_bytes_size(const pointreel_bytes* handle) {
  const auto bytes = encoded().find(handle);
  return bytes ? bytes->size() : 0;
}

void pointreel_bytes_close(pointreel_bytes* bytes) { encoded().close(bytes); }

pointreel_status pointreel_decode(const void* data, size_t size,
                                  const pointreel_read_options* options, pointreel_frame** frame) {
  return guarded([&]() -> Result<void> {
    TRY(clear(frame));
    if (data == nullptr && size > 0) return fail(ErrorCode::argument, "the bytes are NULL");
    const ByteView bytes(static_cast<const std::uint8_t*>(data), size);
    return give_frame(decode_bytes(bytes, TRY(limits_of(options))), frame);
  });
}

// --- Packages ------------------------------------------------------------------------------------

pointreel_status pointreel_writer_open(const char* folder, const pointreel_write_options* given,
                                       const pointreel_encode_options* encode,
                                       pointreel_writer** writer) {
  return guarded([&]() -> Result<void> {
    TRY(clear(writer));
    const pointreel_write_options options = TRY(options_of(given, "pointreel_write_options"));
    PackOptions write;
    static_cast<EncodingOptions&>(write) = TRY(encoding_of(encode));
    write.output = TRY(text_of(folder, "the folder"));
    if (write.output.empty()) return fail(ErrorCode::argument, "the folder has no name");
    write.name = text_or_nothing(options.name);
    if (options.fps != 0.0) write.fps = options.fps;
    if (options.up != 0) write.up = TRY(up_of(options.up));
    if (options.segment_frames != 0) write.segment_frames = options.segment_frames;
    write.force = options.replace != 0;
    const std::stop_token stop = TRY(stop_of(options.canceller));
    auto package = TRY(PackageWriter::create(write));
    *writer = writers().add(std::shared_ptr<Writer>(
        new Writer{.mutex = {}, .package = std::move(package), .stop = stop}));
    return {};
  });
}

pointreel_status pointreel_writer_add(pointreel_writer* handle, const pointreel_points* points,
                                      uint64_t time_us) {
  return guarded([&]() -> Result<void> {
    const auto writer = TRY(writers().get(handle, "the writer"));
    PointCloud cloud = TRY(cloud_of(points));
    const auto time =
        time_us == POINTREEL_BY_FPS ? std::nullopt : std::optional<std::uint64_t>(time_us);
    const std::lock_guard lock(writer->mutex);
    return writer->package.add(std::move(cloud), time, writer->stop);
  });
}

pointreel_status pointreel_writer_finish(pointreel_writer* handle) {
  return guarded([&]() -> Result<void> {
    const auto writer = TRY(writers().get(handle, "the writer"));
    const std::lock_guard lock(writer->mutex);
    return writer->package.finish(writer->stop);
  });
}

void pointreel_writer_close(pointreel_writer* writer) { writers().close(writer); }
