#include "client/scene/camera_path.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <initializer_list>
#include <numbers>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "codec/core/json_fields.h"
#include "codec/core/write_json.h"
#include "common/base/try.h"
#include "common/base/words.h"
#include "common/file_system/write_file.h"

namespace pointreel {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kMaxSeconds = 1e9, kMaxCoordinate = 1e12, kMaxYaw = 1e6;
constexpr double kMinDistance = 1e-9, kMaxDistance = 1e12;
constexpr double kMinFov = 1.0 * kDegree, kMaxFov = 170.0 * kDegree;
constexpr std::size_t kMaxFileBytes = std::size_t{4} << 20;
constexpr std::uint64_t kVersion = 1;

/// The values that are interpolated: target, logarithm of the distance, yaw, pitch, field of view.
constexpr std::size_t kYaw = 4;
using Values = std::array<double, 7>;

Values values_of(const CameraKey& key, const Camera& framed) {
  const glm::dvec3 target = key.target.value_or(framed.target);
  return {target.x,
          target.y,
          target.z,
          std::log(key.distance.value_or(framed.distance)),
          key.yaw,
          key.pitch,
          key.fov_y.value_or(framed.fov_y)};
}

/// The slope of the cubics at a key, from the slopes of the intervals before and after it and from
/// their lengths.
double inner_slope(double before, double after, double before_length, double after_length) {
  if (!(before * after > 0.0)) return 0.0;
  const double w1 = 2.0 * after_length + before_length, w2 = after_length + 2.0 * before_length;
  return (w1 + w2) / (w1 / before + w2 / after);
}

/// The same at the first or last key, from the slope of the interval beside it and of the one
/// beyond.
double end_slope(double near, double far, double near_length, double far_length) {
  const double slope =
      ((2.0 * near_length + far_length) * near - near_length * far) / (near_length + far_length);
  if (!(slope * near > 0.0)) return 0.0;
  return near * far <= 0.0 && std::abs(slope) > 3.0 * std::abs(near) ? 3.0 * near : slope;
}

/// The cubic from a to b with these slopes at its ends, for t from 0 to 1.
double hermite(double a, double b, double a_slope, double b_slope, double length, double t) {
  const double u = 1.0 - t;
  const double value = a * (1.0 + 2.0 * t) * u * u + b * (3.0 - 2.0 * t) * t * t +
                       length * t * u * (a_slope * u - b_slope * t);
  return std::clamp(value, std::min(a, b), std::max(a, b));
}

void refuse_outside(Fields& fields, const char* key, double value, double min, double max) {
  if (!(value >= min && value <= max))
    fields.refuse(key, fmt::format("is not from {} to {}", number_text(min), number_text(max)));
}

/// A misspelt name would have no effect, and nobody would be told.
void refuse_others(Fields& fields, const JsonValue& json,
                   std::initializer_list<std::string_view> known) {
  if (fields.error()) return;
  for (JsonItems item(json); item.next();) {
    const std::string name = item.key().string().value_or(std::string());
    if (std::find(known.begin(), known.end(), name) == known.end())
      fields.refuse(name,
                    fmt::format("is not known here; there may be {}", fmt::join(known, ", ")));
  }
}

Result<CameraKey> parse_key(const JsonValue& json) {
  Fields fields(json);
  refuse_others(fields, json, {"seconds", "target", "distance", "yaw", "pitch", "fov"});
  CameraKey key;
  const double seconds = fields.number("seconds");
  refuse_outside(fields, "seconds", seconds, 0.0, kMaxSeconds);
  if (fields.has("target")) {
    key.target = fields.vector("target");
    for (int axis = 0; axis < 3; ++axis)
      refuse_outside(fields, "target", (*key.target)[axis], -kMaxCoordinate, kMaxCoordinate);
  }
  if (fields.has("distance")) {
    key.distance = fields.number("distance");
    refuse_outside(fields, "distance", *key.distance, kMinDistance, kMaxDistance);
  }
  const auto angle = [&](const char* name, double min, double max) {
    const double degrees = fields.number(name);
    refuse_outside(fields, name, degrees, std::round(min / kDegree), std::round(max / kDegree));
    return std::clamp(degrees * kDegree, min, max);
  };
  if (fields.has("yaw")) key.yaw = angle("yaw", -kMaxYaw, kMaxYaw);
  if (fields.has("pitch")) key.pitch = angle("pitch", -kTurn / 4.0, kTurn / 4.0);
  if (fields.has("fov")) key.fov_y = angle("fov", kMinFov, kMaxFov);
  if (fields.error()) return tl::unexpected(*fields.error());
  key.time_us = static_cast<std::uint64_t>(std::llround(seconds * 1e6));
  return key;
}

double degrees(double radians) { return std::round(radians / kDegree * 1e9) / 1e9; }

}  // namespace

CameraKey key_of(const Camera& camera, std::uint64_t time_us) {
  return {time_us, camera.target, camera.distance, camera.yaw, camera.pitch, camera.fov_y};
}

void CameraPath::set(const CameraKey& key) {
  const auto at =
      std::lower_bound(keys.begin(), keys.end(), key.time_us,
                       [](const CameraKey& k, std::uint64_t time) { return k.time_us < time; });
  if (at != keys.end() && at->time_us == key.time_us) {
    *at = key;
  } else {
    keys.insert(at, key);
  }
}

Camera CameraPath::at(std::uint64_t time_us, const Camera& framed) const {
  // The keys of the interval and one more on each side: first <= a < b <= last.
  const auto after =
      std::upper_bound(keys.begin(), keys.end(), time_us,
                       [](std::uint64_t time, const CameraKey& k) { return time < k.time_us; });
  const auto b = static_cast<std::size_t>(after - keys.begin());
  Values now;
  if (b == 0 || b == keys.size()) {
    now = values_of(b == 0 ? keys.front() : keys.back(), framed);
  } else {
    const std::size_t a = b - 1, first = a > 0 ? a - 1 : a, last = std::min(b + 1, keys.size() - 1);
    const auto seconds = [&](std::size_t from, std::size_t to) {
      return static_cast<double>(keys[to].time_us - keys[from].time_us) / 1e6;
    };
    std::array<Values, 4> v;  // the values of first, a, b and last
    const std::array<std::size_t, 4> index = {first, a, b, last};
    for (std::size_t i = 0; i < 4; ++i) v[i] = values_of(keys[index[i]], framed);
    const auto near = [](double yaw, double to) { return to + std::remainder(yaw - to, kTurn); };
    v[0][kYaw] = near(v[0][kYaw], v[1][kYaw]);
    v[2][kYaw] = near(v[2][kYaw], v[1][kYaw]);
    v[3][kYaw] = near(v[3][kYaw], v[2][kYaw]);

    const double length = seconds(a, b);
    const double t = static_cast<double>(time_us - keys[a].time_us) / 1e6 / length;
    for (std::size_t i = 0; i < now.size(); ++i) {
      const double slope = (v[2][i] - v[1][i]) / length;
      const double before = first < a ? (v[1][i] - v[0][i]) / seconds(first, a) : slope;
      const double beyond = b < last ? (v[3][i] - v[2][i]) / seconds(b, last) : slope;
      double a_slope = slope, b_slope = slope;
      if (first < a) {
        a_slope = inner_slope(before, slope, seconds(first, a), length);
      } else if (b < last) {
        a_slope = end_slope(slope, beyond, length, seconds(b, last));
      }
      if (b < last) {
        b_slope = inner_slope(slope, beyond, length, seconds(b, last));
      } else if (first < a) {
        b_slope = end_slope(slope, before, length, seconds(first, a));
      }
      now[i] = hermite(v[1][i], v[2][i], a_slope, b_slope, length, t);
    }
  }
  Camera camera = framed;
  camera.up = up.value_or(framed.up);
  camera.target = {now[0], now[1], now[2]};
  camera.distance = std::exp(now[3]);
  camera.yaw = camera.pitch = 0.0;
  camera.orbit(now[kYaw], now[5]);
  camera.fov_y = now[6];
  return camera;
}

Result<CameraPath> parse_camera_path(std::string_view text) {
  const auto root = TRY(parse_json(text));
  Fields fields(root);
  const std::uint64_t version = fields.integer("pointreel_camera_path", kMaxInteger);
  if (fields.error()) return fail_at("is not a camera path", *fields.error());
  if (version != kVersion)
    return fail(ErrorCode::unsupported,
                fmt::format("is a camera path of format {}, but this player reads format {}",
                            version, kVersion));
  refuse_others(fields, root, {"pointreel_camera_path", "up", "keys"});
  CameraPath path;
  if (fields.has("up")) {
    path.up = parse_up(fields.text("up"));
    if (!path.up) fields.refuse("up", fmt::format("is not one of {}", kUpNames));
  }
  const JsonValue keys = fields.array("keys");
  const std::size_t count = keys.size();
  if (count == 0 || count > kMaxCameraKeys)
    fields.refuse("keys", fmt::format("must be a list of 1 to {}", kMaxCameraKeys));
  if (fields.error()) return tl::unexpected(*fields.error());
  for (JsonItems item(keys); item.next();) {
    const std::string place = fmt::format("keys[{}]", path.keys.size());
    const auto key = parse_key(item.value());
    if (!key) return fail_at(place, key.error());
    if (!path.keys.empty() && key->time_us <= path.keys.back().time_us)
      return fail(place + ": seconds: must be greater than those of the key before");
    path.keys.push_back(*key);
  }
  return path;
}

std::string write_camera_path(const CameraPath& path) {
  std::string text = fmt::format("{{\"pointreel_camera_path\": {},", kVersion);
  if (path.up) text += fmt::format(" \"up\": \"{}\",", path.up->text());
  text += " \"keys\": [";
  for (std::size_t i = 0; i < path.keys.size(); ++i) {
    const CameraKey& key = path.keys[i];
    nlohmann::ordered_json json;
    json["seconds"] = static_cast<double>(key.time_us) / 1e6;
    if (key.target) json["target"] = vector_json(*key.target);
    if (key.distance) json["distance"] = *key.distance;
    json["yaw"] = degrees(key.yaw);
    json["pitch"] = degrees(key.pitch);
    if (key.fov_y) json["fov"] = degrees(*key.fov_y);
    text += (i > 0 ? ",\n  " : "\n  ") + dump(json);
  }
  return text + "\n]}\n";
}

Result<CameraPath> load_camera_path(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in)
    return fail(errno == ENOENT ? ErrorCode::not_found : ErrorCode::io,
                fmt::format("{}: cannot be opened: {}", file, std::strerror(errno)));
  std::string text(kMaxFileBytes + 1, '\0');
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (in.bad()) return fail(ErrorCode::io, file + ": cannot be read");
  text.resize(static_cast<std::size_t>(in.gcount()));
  if (text.size() > kMaxFileBytes)
    return fail(ErrorCode::limit, file + ": is not a camera path: it is larger than 4 MiB");
  auto path = parse_camera_path(text);
  if (!path) return fail_at(file, path.error());
  return path;
}

Result<void> save_camera_path(const std::string& file, const CameraPath& path) {
  return replace_file(file, write_camera_path(path));
}

}  // namespace pointreel
