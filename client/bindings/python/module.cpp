// The module pointreel._native, on which pointreel/__init__.py stands.
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "client/bindings/frames/encoded_bytes.h"
#include "client/bindings/frames/encoding_choice.h"
#include "client/bindings/frames/frame_cleaner.h"
#include "client/bindings/frames/frame_publisher.h"
#include "client/bindings/frames/point_arrays.h"
#include "client/bindings/frames/read_ahead.h"
#include "client/bindings/python/arrays.h"
#include "client/bindings/python/call.h"
#include "client/bindings/python/picture.h"
#include "client/scene/named_views.h"
#include "client/source/open_live_source.h"
#include "client/source/open_source.h"
#include "codec/core/reel_rules.h"
#include "codec/package/manifest.h"
#include "codec/rate/bitrate.h"
#include "codec/segments/package_writer.h"
#include "common/base/concat.h"
#include "common/base/try.h"
#include "common/net/url.h"
#include "pointreel/version.h"

namespace py = pybind11;

namespace pointreel {
namespace {

using Positions = py::array;
using Attribute = std::optional<py::array>;
using Vector = std::array<double, 3>;

glm::dvec3 to_glm(const Vector& v) { return {v[0], v[1], v[2]}; }

Up up_of(const std::string& text) {
  const auto up = parse_up(text);
  if (!up) raise({std::string("up is one of ") + kUpNames, ErrorCode::argument});
  return *up;
}

SourceOptions source_options(std::string token, std::string ca_file, bool follow_redirects) {
  SourceOptions options;
  options.token = std::move(token);
  options.ca_file = std::move(ca_file);
  options.follow_redirects = follow_redirects;
  return options;
}

ReadLimits read_limits(std::optional<std::uint32_t> layers,
                       std::optional<std::uint64_t> max_memory) {
  ReadLimits limits;
  if (layers) limits.layers = *layers;
  if (max_memory) limits.max_memory = *max_memory;
  return limits;
}

/// How frames are encoded, as video or one by one.
struct PyEncoding : EncodingOptions {
  bool video = false;
};

PyEncoding encoding(const std::string& codec, int depth, double voxel, int color_quality,
                    int normal_quality, bool fast, double delta,
                    const std::map<std::string, double>& scalar_steps) {
  EncodingChoice choice;
  if (codec == name(Codec::draco)) {
    choice.codec = Codec::draco;
  } else if (codec == name(Codec::video)) {
    choice.codec = Codec::video;
  } else if (codec != name(Codec::octree)) {
    raise({"codec is octree or draco, or video for pack, not " + codec, ErrorCode::argument});
  }
  choice.depth = depth;
  choice.voxel = voxel;
  choice.color_quality = color_quality;
  choice.normal_quality = normal_quality;
  choice.fast = fast;
  choice.delta = delta;
  for (const auto& [field, step] : scalar_steps) choice.scalar_steps.push_back({field, step});
  return {value_or_raise(encoding_of(choice)), choice.codec == Codec::video};
}

/// For frames that are not of a package.
const EncodingOptions& one_by_one(const PyEncoding& encoding) {
  if (encoding.video)
    raise({"codec=\"video\" is for pack: frames by themselves are octree or draco",
           ErrorCode::argument});
  return encoding;
}

int within(const char* argument, int value, int least, int most) {
  if (value < least || value > most)
    raise({concat(argument, " is ", value, ", not ", least, " to ", most), ErrorCode::argument});
  return value;
}

/// Absent values have the defaults of the command.
PackOptions packing(const PyEncoding& encoding, const std::optional<std::string>& bitrate,
                    std::optional<int> segment, std::optional<int> group, std::optional<int> effort,
                    const std::string& cube, const std::string& normals, bool best_effort) {
  PackOptions options;
  static_cast<EncodingOptions&>(options) = encoding;
  if (bitrate) options.bitrate = value_or_raise(at_place("bitrate", parse_bitrate(*bitrate)));
  if (cube != "group" && cube != "frame")
    raise({"cube is group or frame, not " + cube, ErrorCode::argument});
  options.cube_per_frame = cube == "frame";
  if (normals == "auto") {
    options.missing_normals = MissingNormals::estimated_if_it_pays;
  } else if (normals == "estimate" && encoding.encode.id() == Codec::octree && !encoding.video) {
    options.missing_normals = MissingNormals::estimated;
  } else if (normals == "estimate") {
    raise({"normals=\"estimate\" needs codec=\"octree\"", ErrorCode::argument});
  } else if (normals == "derive") {
    options.encode.normals = false;
  } else if (normals != "send") {
    raise({"normals is auto, send, estimate or derive, not " + normals, ErrorCode::argument});
  }
  options.best_effort = best_effort;
  if (encoding.video) {
    VideoPackOptions video;
    video.quality = std::get<OctreeOptions>(encoding.encode.codec).color_quality;
    if (group)
      video.group_frames = static_cast<std::uint32_t>(within("group", *group, 1, kMostGroupFrames));
    if (effort) video.effort = within("effort", *effort, 0, kMostVideoEffort);
    options.pack_as_video(video);
  } else if (group || effort) {
    raise({concat(group ? "group" : "effort", " needs codec=\"video\""), ErrorCode::argument});
  }
  if (segment)
    options.segment_frames =
        static_cast<std::uint32_t>(within("segment", *segment, 1, kMostSegmentFrames));
  return options;
}

std::optional<std::uint64_t> microseconds(std::optional<double> seconds) {
  if (!seconds) return std::nullopt;
  if (!(*seconds >= 0.0 && *seconds < 1e10))
    raise({"a time is in seconds, and not below 0", ErrorCode::argument});
  return static_cast<std::uint64_t>(std::llround(1e6 * *seconds));
}

/// How files are read.
struct FileOptions {
  std::optional<double> fps;
  std::string topic;
  Reading reading;
  Placement placement;
};

FileOptions file_options(std::optional<double> fps, std::string topic,
                         std::vector<std::string> columns, double color_max, double scale,
                         const Vector& rotate) {
  if (fps && !is_frame_rate(*fps)) raise({"fps is out of range", ErrorCode::argument});
  if (color_max != 0.0 && color_max != 1.0 && color_max != 255.0 && color_max != 65535.0)
    raise({"color_max is 1, 255 or 65535", ErrorCode::argument});
  if (!(scale > 0.0 && scale < 1e9)) raise({"scale is above 0", ErrorCode::argument});
  FileOptions options{fps, std::move(topic), {std::move(columns), color_max}, {}};
  options.placement.scale = scale;
  options.placement.rotation = rotation_of(to_glm(rotate));
  return options;
}

/// Lines about files, from any thread.
class Lines {
 public:
  void add(const std::string& line) {
    const std::lock_guard lock(mutex_);
    constexpr std::string_view kWarning = "warning: ";
    const std::size_t begin = line.starts_with(kWarning) ? kWarning.size() : 0;
    lines_.push_back(for_python(line.substr(begin)));
  }
  std::vector<std::string> take() {
    const std::lock_guard lock(mutex_);
    return std::exchange(lines_, {});
  }

 private:
  std::mutex mutex_;
  std::vector<std::string> lines_;
};

class PyReel {
 public:
  PyReel(const std::string& where, const FileOptions& file, std::string token, std::string ca_file,
         bool follow_redirects)
      : remote_(!scheme_of(where).empty()) {
    SourceOptions options = source_options(std::move(token), std::move(ca_file), follow_redirects);
    options.fps = file.fps;
    options.topic = file.topic;
    options.reading = file.reading;
    options.placement = file.placement;
    options.say = [lines = lines_](const std::string& line) { lines->add(line); };
    frames_ = std::make_shared<const ReelFrames>(interruptible([&](const std::stop_token& stop) {
      SourceOptions stoppable = options;
      stoppable.stop = stop;
      return open_source(where, stoppable);
    }));
  }

  const Manifest& manifest() const { return frames_->manifest(); }
  std::size_t size() const { return frames_->size(); }

  std::string metadata() const { return write_manifest(manifest()); }
  std::string trouble() const { return frames_->source().trouble().value_or(""); }
  /// What there is to say about files since the last call.
  std::vector<std::string> said() const { return lines_->take(); }
  py::object bounds() const { return box_of(manifest().bounds); }

  py::array times() const {
    std::vector<double> seconds;
    seconds.reserve(size());
    for (std::uint32_t i = 0; i < size(); ++i)
      seconds.push_back(static_cast<double>(*frames_->time_us(i)) / 1e6);
    return py::array_t<double>(static_cast<py::ssize_t>(seconds.size()), seconds.data());
  }

  PyFrame read(std::uint32_t index, std::optional<std::uint32_t> layers,
               std::optional<std::uint64_t> max_memory) const {
    ReadLimits limits = read_limits(layers, max_memory);
    if (!remote_) return {without_gil([&] { return frames_->read(index, limits); })};
    return {interruptible([&](const std::stop_token& stop) {
      limits.stop = stop;
      return frames_->read(index, limits);
    })};
  }

  std::unique_ptr<ReadAhead> read_ahead(std::vector<std::uint32_t> order,
                                        std::optional<std::uint32_t> layers,
                                        std::optional<std::uint64_t> max_memory,
                                        std::size_t ahead) const {
    return std::make_unique<ReadAhead>(frames_, std::move(order), read_limits(layers, max_memory),
                                       std::max<std::size_t>(1, ahead));
  }

 private:
  bool remote_ = false;
  std::shared_ptr<Lines> lines_ = std::make_shared<Lines>();
  std::shared_ptr<const ReelFrames> frames_;
};

PyFrame next_of(ReadAhead& ahead) {
  auto frame = until_signalled(
      [&](std::chrono::milliseconds time) -> std::optional<std::optional<Result<SharedFrame>>> {
        auto next = ahead.next(time);
        if (next || ahead.ended()) return next;
        return std::nullopt;
      });
  if (!frame) throw py::stop_iteration();
  return {value_or_raise(std::move(*frame))};
}

class PyLive {
 public:
  PyLive(const std::string& url, std::string token, std::string ca_file, bool follow_redirects)
      : source_(without_gil([&] {
          return open_live_source(
              url, source_options(std::move(token), std::move(ca_file), follow_redirects));
        })) {}

  /// None if nothing has come by then.
  std::optional<PyFrame> next(std::optional<double> timeout, std::optional<std::uint32_t> layers,
                              std::optional<std::uint64_t> max_memory) {
    using Clock = std::chrono::steady_clock;
    const auto end = timeout ? std::optional(Clock::now() + std::chrono::duration<double>(
                                                                std::clamp(*timeout, 0.0, 1e6)))
                             : std::nullopt;
    std::optional<LiveFrame> frame = until_signalled(
        [&](std::chrono::milliseconds time) -> std::optional<std::optional<LiveFrame>> {
          auto newest = source_->next(time);
          if (newest || source_->refusal() || (end && Clock::now() >= *end)) return newest;
          return std::nullopt;
        });
    if (!frame) {
      if (auto refusal = source_->refusal()) raise(*std::move(refusal));
      return std::nullopt;
    }
    const ReadLimits limits = read_limits(layers, max_memory);
    return PyFrame{without_gil([&] {
      const auto hello = source_->hello(std::chrono::milliseconds(0));
      return decode_live(std::move(*frame), limits, hello ? hello->up : Up('y'));
    })};
  }

  std::string trouble() const { return source_->trouble().value_or(""); }

 private:
  std::unique_ptr<LiveSource> source_;
};

class PyWriter {
 public:
  PyWriter(const std::string& folder, const std::string& title, double fps, const std::string& up,
           bool replace, const PackOptions& packing)
      : writer_([&] {
          if (!scheme_of(folder).empty())
            raise({folder + ": is an address, but packages are written into folders; "
                            "\"pointreel-server upload\" sends them to object stores",
                   ErrorCode::argument});
          PackOptions options = packing;
          options.output = folder;
          options.name = title;
          options.fps = fps;
          options.up = up_of(up);
          options.force = replace;
          return without_gil([&] { return PackageWriter::create(options); });
        }()) {}

  void add(const Positions& positions, const Attribute& colors, const Attribute& normals,
           const Vector& origin, const py::dict& scalars, std::optional<double> time) {
    add(cloud_of(positions, colors, normals, to_glm(origin), scalars), microseconds(time));
  }

  void add_frame(const PyFrame& frame, std::optional<double> time) {
    PointCloud copy = frame.frame->cloud;
    add(std::move(copy), microseconds(time));
  }

  void captured(double unix_time) { writer_.captured(*microseconds(unix_time)); }
  void finish() {
    interruptible([&](const std::stop_token& stop) { return writer_.finish(stop); });
  }
  /// What there is to say about the frames since the last call.
  std::vector<std::string> said() {
    std::vector<std::string> lines = writer_.take_warnings();
    for (std::string& line : lines) line = for_python(line);
    return lines;
  }

 private:
  void add(PointCloud cloud, std::optional<std::uint64_t> time_us) {
    interruptible(
        [&](const std::stop_token& stop) { return writer_.add(std::move(cloud), time_us, stop); });
  }

  PackageWriter writer_;
};

class PyPublisher {
 public:
  PyPublisher(const std::string& url, const std::string& token, const std::string& ca_file,
              const std::string& title, double fps, const std::string& up,
              const PyEncoding& encoding) {
    EncodingOptions options = one_by_one(encoding);
    options.name = title;
    options.fps = fps;
    options.up = up_of(up);
    publisher_ = interruptible([&](const std::stop_token& stop) {
      return FramePublisher::open(url, token, ca_file, options, stop);
    });
  }

  void send(const Positions& positions, const Attribute& colors, const Attribute& normals,
            const Vector& origin, const py::dict& scalars, std::optional<double> time) {
    send(cloud_of(positions, colors, normals, to_glm(origin), scalars), time);
  }
  void send_frame(const PyFrame& frame, std::optional<double> time) {
    send(frame.frame->cloud, time);
  }
  void flush() {
    const ReleasedGil released;
    publisher_->flush();
  }
  std::string trouble() const { return publisher_->trouble(); }
  std::uint32_t sent() const { return publisher_->sent(); }
  std::uint64_t accepted() const { return publisher_->accepted(); }

 private:
  void send(const PointCloud& cloud, std::optional<double> time) {
    const auto time_us = microseconds(time);
    without_gil([&] {
      const std::lock_guard lock(mutex_);
      return publisher_->send(cloud, time_us);
    });
  }

  std::mutex mutex_;  ///< frames are sent one after another
  std::unique_ptr<FramePublisher> publisher_;
};

class PyCleaner {
 public:
  PyCleaner(std::optional<double> radius, std::size_t before, std::size_t after)
      : cleaner_([&] {
          FrameCleaner::Options options;
          options.before = before;
          options.after = after;
          options.clean.radius = radius;
          return value_or_raise(FrameCleaner::make(options));
        }()) {}

  void add(const Positions& positions, const Attribute& colors, const Attribute& normals,
           const Vector& origin, const py::dict& scalars, std::optional<double>) {
    add(cloud_of(positions, colors, normals, to_glm(origin), scalars));
  }
  void add_frame(const PyFrame& frame, std::optional<double>) {
    add(PointCloud(frame.frame->cloud));
  }
  void end() {
    const std::lock_guard lock(mutex_);
    cleaner_.end();
  }
  std::optional<PyFrame> next() {
    SharedFrame frame = without_gil([&] {
      const std::lock_guard lock(mutex_);
      return cleaner_.next();
    });
    return frame ? std::optional(PyFrame{std::move(frame)}) : std::nullopt;
  }

 private:
  void add(PointCloud cloud) {
    without_gil([&] {
      const std::lock_guard lock(mutex_);
      return cleaner_.add(std::move(cloud));
    });
  }

  std::mutex mutex_;
  FrameCleaner cleaner_;
};

/// The points of arrays as a frame, to be drawn.
PyFrame frame_of(const Positions& positions, const Attribute& colors, const Attribute& normals,
                 const Vector& origin, const py::dict& scalars) {
  auto frame = std::make_shared<PointFrame>();
  frame->cloud = cloud_of(positions, colors, normals, to_glm(origin), scalars);
  return {std::move(frame)};
}

py::bytes encode(const Positions& positions, const Attribute& colors, const Attribute& normals,
                 const Vector& origin, const py::dict& scalars, const PyEncoding& encoding) {
  const EncodingOptions& options = one_by_one(encoding);
  const PointCloud cloud = cloud_of(positions, colors, normals, to_glm(origin), scalars);
  const Bytes bytes = without_gil([&]() -> Result<Bytes> {
    const EncodedFrame frame = TRY(encode_points(cloud, options));
    return frame_bytes(frame);
  });
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

PyFrame decode(const py::buffer& data, std::optional<std::uint32_t> layers,
               std::optional<std::uint64_t> max_memory) {
  const py::buffer_info info = data.request();
  py::ssize_t contiguous = info.itemsize;
  for (py::ssize_t axis = info.ndim; axis-- > 0;
       contiguous *= info.shape[static_cast<std::size_t>(axis)])
    if (info.strides[static_cast<std::size_t>(axis)] != contiguous)
      raise({"the bytes have gaps", ErrorCode::argument});
  const ByteView bytes(static_cast<const std::uint8_t*>(info.ptr),
                       static_cast<std::size_t>(info.size * info.itemsize));
  const ReadLimits limits = read_limits(layers, max_memory);
  return {without_gil([&] { return decode_bytes(bytes, limits); })};
}

py::array picture(const PyFrame& frame, int width, int height, const std::string& mode,
                  std::optional<std::array<double, 2>> view, double zoom, const std::string& up,
                  const std::optional<std::array<Vector, 2>>& bounds,
                  const std::array<float, 3>& background, const std::string& color,
                  const std::string& light, const std::optional<Vector>& target,
                  std::optional<double> target_height,
                  const std::optional<std::array<double, 2>>& color_range) {
  PictureOptions options;
  options.size = {width, height};
  const auto known_mode = parse_enum<DrawMode>(mode);
  if (!known_mode)
    raise({"mode is surfel, voxel, point or strip, not " + mode, ErrorCode::argument});
  options.mode = *known_mode;
  options.up = up_of(up);
  if (view) options.view = glm::dvec2((*view)[0], (*view)[1]);
  options.zoom = zoom;
  if (bounds) options.box = Box{to_glm((*bounds)[0]), to_glm((*bounds)[1])};
  options.background = {background[0], background[1], background[2]};
  if (const auto source = parse_enum<ColorSource>(color)) {
    options.color = *source;
  } else if (std::ranges::find(frame.frame->cloud.scalars, color, &ScalarField::name) !=
             frame.frame->cloud.scalars.end()) {
    options.scalar.field = color;
  } else {
    raise(
        {"color is not one of those that help(render) names, and the frame has no such scalar "
         "field: " +
             color,
         ErrorCode::argument});
  }
  if (color_range) {
    if (options.scalar.field.empty())
      raise({"color_range goes with a color that is a scalar field", ErrorCode::argument});
    options.scalar.range = glm::dvec2((*color_range)[0], (*color_range)[1]);
  }
  if (light != "flat" && light != "studio" && light != "none")
    raise({"light is flat, studio or none, not " + light, ErrorCode::argument});
  options.lit = light != "none";
  options.light = light == "studio" ? Light::studio : Light::flat;
  if (target) options.target = to_glm(*target);
  if (target_height) options.target = *target_height;
  const Image image = without_gil([&] { return picture_of(*frame.frame, options); });
  py::array_t<std::uint8_t> array({height, width, 3});
  std::memcpy(array.mutable_data(), image.pixels.data(), image.pixels.size() * 3);
  return array;
}

std::string describe(const PyFrame& frame) {
  const PointCloud& cloud = frame.frame->cloud;
  return "<pointreel.Frame " + std::to_string(frame.frame->info.index) + " of " +
         std::to_string(cloud.size()) + " points" + (cloud.has_colors() ? ", colors" : "") +
         (cloud.has_normals() ? ", normals" : "") + (cloud.has_scalars() ? ", scalars" : "") + ">";
}

/// Leaves making instances to the module: those that Python's __new__ makes have no value, and
/// pybind11 takes memory that is not initialised for it.
void forbid_construction(const py::object& type) {
  reinterpret_cast<PyTypeObject*>(type.ptr())->tp_new = nullptr;
}

}  // namespace
}  // namespace pointreel

PYBIND11_MODULE(_native, module) {
  using namespace pointreel;
  module.attr("__version__") = POINTREEL_VERSION;
  py::dict views, heights;
  for (const auto& [name, yaw, pitch] : kNamedViews)
    views[py::str(name)] = py::make_tuple(glm::degrees(yaw), glm::degrees(pitch));
  for (const auto& [name, height] : kNamedHeights) heights[py::str(name)] = height;
  module.attr("views") = views;
  module.attr("heights") = heights;
  add_error(module);

  py::class_<PyFrame> frame(module, "Frame", "The points of a frame, which do not change.");
  forbid_construction(frame);
  frame.def("__len__", [](const PyFrame& self) { return self.frame->cloud.size(); })
      .def("__repr__", describe)
      .def_property_readonly("positions", positions_of,
                             "float32, n x 3, relative to `origin`: the frame's memory itself.")
      .def_property_readonly("colors", colors_of,
                             "uint16, n x 3, sRGB, or None: the frame's memory itself. An 8-bit "
                             "value v is 257 v; `colors8` has 8 bits.")
      .def_property_readonly("colors8", colors8_of, "uint8, n x 3, sRGB, or None: a copy.")
      .def_property_readonly("normals", normals_of,
                             "float32, n x 3, of unit length or zero where unknown, or None: the "
                             "frame's memory itself.")
      .def_property_readonly("scalars", scalars_of,
                             "A dict of the scalar fields, such as intensities: name to float32, "
                             "n, NaN where unknown, each the frame's memory itself.")
      .def_property_readonly("world", world_of, "float64, n x 3: origin + positions, a copy.")
      .def_property_readonly(
          "origin", [](const PyFrame& self) { return vector_of(self.frame->cloud.origin); },
          "float64, 3.")
      .def_property_readonly(
          "index", [](const PyFrame& self) { return self.frame->info.index; },
          "The frame's number in its reel or stream.")
      .def_property_readonly(
          "time",
          [](const PyFrame& self) { return static_cast<double>(self.frame->info.time_us) / 1e6; },
          "Seconds from the reel's start; of live streams, Unix time of the capture.")
      .def_property_readonly(
          "up", [](const PyFrame& self) { return self.frame->up.text(); },
          "The axis that points up in its reel or stream: x, -x, y, -y, z or -z; else y.")
      .def_property_readonly(
          "layers", [](const PyFrame& self) { return self.frame->layers; },
          "How many layers it was decoded from; 0 for a file.");

  py::class_<ReadAhead> read_ahead(module, "ReadAhead");
  forbid_construction(read_ahead);
  read_ahead.def("__iter__", [](const py::object& self) { return self; }).def("__next__", next_of);

  py::class_<FileOptions>(module, "FileOptions").def(py::init(&file_options));

  py::class_<PyReel>(module, "Reel")
      .def(py::init<const std::string&, const FileOptions&, std::string, std::string, bool>())
      .def("__len__", &PyReel::size)
      .def("metadata", &PyReel::metadata)
      .def("trouble", &PyReel::trouble)
      .def("said", &PyReel::said)
      .def("bounds", &PyReel::bounds)
      .def("times", &PyReel::times)
      .def("read", &PyReel::read)
      .def("read_ahead", &PyReel::read_ahead);

  py::class_<PyLive>(module, "Live")
      .def(py::init<const std::string&, std::string, std::string, bool>())
      .def("next", &PyLive::next)
      .def("trouble", &PyLive::trouble);

  py::class_<PyEncoding>(module, "Encoding").def(py::init(&encoding));
  py::class_<PackOptions>(module, "Packing").def(py::init(&packing));

  py::class_<PyWriter>(module, "Writer")
      .def(py::init<const std::string&, const std::string&, double, const std::string&, bool,
                    const PackOptions&>())
      .def("add",
           py::overload_cast<const Positions&, const Attribute&, const Attribute&, const Vector&,
                             const py::dict&, std::optional<double>>(&PyWriter::add))
      .def("add_frame", &PyWriter::add_frame)
      .def("captured", &PyWriter::captured)
      .def("finish", &PyWriter::finish)
      .def("said", &PyWriter::said);

  py::class_<PyPublisher>(module, "Publisher")
      .def(py::init<const std::string&, const std::string&, const std::string&, const std::string&,
                    double, const std::string&, const PyEncoding&>())
      .def("send",
           py::overload_cast<const Positions&, const Attribute&, const Attribute&, const Vector&,
                             const py::dict&, std::optional<double>>(&PyPublisher::send))
      .def("send_frame", &PyPublisher::send_frame)
      .def("flush", &PyPublisher::flush)
      .def("trouble", &PyPublisher::trouble)
      .def("sent", &PyPublisher::sent)
      .def("accepted", &PyPublisher::accepted);

  py::class_<PyCleaner>(module, "Cleaner")
      .def(py::init<std::optional<double>, std::size_t, std::size_t>())
      .def("add",
           py::overload_cast<const Positions&, const Attribute&, const Attribute&, const Vector&,
                             const py::dict&, std::optional<double>>(&PyCleaner::add))
      .def("add_frame", &PyCleaner::add_frame)
      .def("end", &PyCleaner::end)
      .def("next", &PyCleaner::next);

  module.def("frame", &frame_of);
  module.def("encode", &encode);
  module.def("decode", &decode);
  module.def("picture", &picture);
}
