#include "server/parts/plan.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "codec/cloud_options/cloud_options.h"
#include "codec/files/cloud_file.h"
#include "codec/files/depth_folder.h"
#include "codec/package/package_folder.h"
#include "codec/segments/choose_cleaning.h"
#include "common/base/try.h"
#include "common/file_system/output_folder.h"
#include "common/file_system/write_file.h"
#include "common/process/print.h"
#include "common/threads/stoppable.h"
#include "common/threads/tbb_executor.h"
#include "pointreel/codec.h"
#include "pointreel/version.h"
#include "server/pack/audio.h"
#include "server/pack/in_arena.h"
#include "server/pack/package_tables.h"
#include "server/pack/video_trial.h"

namespace pointreel {
namespace fs = std::filesystem;
namespace {

using nlohmann::ordered_json;

constexpr const char* kPlanName = "plan.json";
constexpr const char* kFormat = "pointreel-plan";

std::string checksum_text(std::uint64_t checksum) { return fmt::format("{:016x}", checksum); }

std::string to_text(const PackPlan& plan) {
  ordered_json json = {{"format", kFormat},
                       {"program", POINTREEL_VERSION},
                       {"arguments", plan.arguments},
                       {"name", plan.name},
                       {"up", nullptr},
                       {"segment_frames", plan.segment_frames},
                       {"force", plan.force},
                       {"noisy", nullptr},
                       {"audio", nullptr},
                       {"tables", nullptr}};
  if (plan.up) json["up"] = plan.up->text();
  if (plan.noisy) json["noisy"] = *plan.noisy;
  if (plan.audio) json["audio"] = plan.audio->string();
  if (plan.tables) {
    json["tables"] = {{"path", plan.tables->path},
                      {"bytes", plan.tables->bytes},
                      {"xxh3", checksum_text(plan.tables->checksum)}};
  }
  ordered_json& frames = json["frames"] = ordered_json::array();
  for (const PlannedFrame& frame : plan.frames) {
    ordered_json& entry = frames.emplace_back(ordered_json{frame.path.string(), frame.bytes});
    if (!frame.index && !frame.time_us) continue;
    entry.push_back(frame.index ? ordered_json(*frame.index) : ordered_json());
    if (frame.time_us) entry.push_back(*frame.time_us);
  }
  return json.dump(1) + "\n";
}

PackPlan from_json(const ordered_json& json) {
  PackPlan plan;
  plan.arguments = json.at("arguments").get<std::vector<std::string>>();
  plan.name = json.at("name").get<std::string>();
  if (const ordered_json& up = json.at("up"); !up.is_null()) {
    plan.up = parse_up(up.get<std::string>());
    if (!plan.up) throw std::invalid_argument("up");
  }
  const auto segment_frames = json.at("segment_frames").get<std::int64_t>();
  if (segment_frames < 1 || segment_frames > 100'000) throw std::invalid_argument("segment_frames");
  plan.segment_frames = static_cast<std::uint32_t>(segment_frames);
  plan.force = json.at("force").get<bool>();
  // Older plans lack it.
  if (const auto noisy = json.find("noisy"); noisy != json.end() && !noisy->is_null())
    plan.noisy = noisy->get<bool>();
  if (const ordered_json& audio = json.at("audio"); !audio.is_null())
    plan.audio = audio.get<std::string>();
  if (const ordered_json& tables = json.at("tables"); !tables.is_null()) {
    plan.tables =
        PackageFile{tables.at("path").get<std::string>(), tables.at("bytes").get<std::uint64_t>(),
                    std::stoull(tables.at("xxh3").get<std::string>(), nullptr, 16)};
    if (plan.tables->bytes > kMaxTablesBytes) throw std::invalid_argument("tables");
  }
  for (const ordered_json& entry : json.at("frames")) {
    PlannedFrame frame{entry.at(0).get<std::string>(), entry.at(1).get<std::uint64_t>(), {}};
    if (entry.size() > 2 && !entry.at(2).is_null()) frame.index = entry.at(2).get<std::uint32_t>();
    if (entry.size() > 3) frame.time_us = entry.at(3).get<std::uint64_t>();
    plan.frames.push_back(std::move(frame));
  }
  return plan;
}

/// The output must be absent, or a package that may be replaced. Nothing is left behind.
Result<void> check_output(const PackOptions& options) {
  return OutputFolder::create(options.output,
                              options.force ? may_replace_package : OutputFolder::MayReplace{})
      .map([](const OutputFolder&) {});
}

/// What a file has of a plan: nothing, if it is something else, or damaged.
ordered_json plan_json(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  const std::string text((std::istreambuf_iterator<char>(in)), {});
  ordered_json json = ordered_json::parse(text, nullptr, false);
  if (!json.is_object() || json.value("format", ordered_json()) != kFormat) return nullptr;
  return json;
}

/// For a new plan. Removes the old one if `force` allows it.
Result<OutputFolder> plan_folder(const fs::path& folder, bool force) {
  std::error_code error;
  if (fs::exists(folder, error) &&
      !(fs::is_directory(folder, error) && fs::is_empty(folder, error))) {
    if (plan_json(folder / kPlanName).is_null()) {
      return fail(ErrorCode::argument,
                  fmt::format("{}: exists, and is not the folder of a plan; remove it first",
                              folder.string()));
    }
    if (!force) {
      return fail(ErrorCode::argument,
                  fmt::format("{}: a plan is there already; go on with pack part, or use --force "
                              "to begin again",
                              folder.string()));
    }
    fs::remove_all(folder, error);
  }
  if (error) return fail(ErrorCode::io, fmt::format("{}: {}", folder.string(), error.message()));
  return OutputFolder::create(folder);
}

Result<std::vector<PlannedFrame>> planned(const std::vector<CloudFrame>& frames) {
  std::vector<PlannedFrame> planned;
  const CloudFrame* last = nullptr;
  for (const CloudFrame& frame : frames) {
    if (last == nullptr || frame.file != last->file) {
      std::error_code error;
      const fs::path path = fs::absolute(frame.file, error).lexically_normal();
      if (error)
        return fail(ErrorCode::io, fmt::format("{}: {}", frame.file.string(), error.message()));
      planned.push_back({path, TRY(bytes_of_source(path)), {}});
    } else {
      planned.push_back(planned.back());
    }
    if (frame.recording != nullptr) planned.back().index = frame.index;
    planned.back().time_us = frame.time_us;
    last = &frame;
  }
  return planned;
}

/// What was not asked for.
Reading guessed(Reading reading, const Reading& asked) {
  if (!asked.columns.empty()) reading.columns.clear();
  if (asked.full_color != 0.0) reading.full_color = 0.0;
  if (asked.omit_constant) reading.omit_constant.reset();
  return reading;
}

}  // namespace

std::span<const PlannedFrame> PackPlan::frames_of(std::uint32_t segment) const {
  const std::size_t first = std::size_t{segment} * segment_frames;
  return std::span(frames).subspan(first,
                                   std::min<std::size_t>(segment_frames, frames.size() - first));
}

Result<std::uint64_t> bytes_of_source(const fs::path& path) {
  std::error_code error;
  std::uint64_t bytes = 0;
  if (!fs::is_directory(path, error)) {
    if (!error) bytes = fs::file_size(path, error);
    if (error) return fail(ErrorCode::io, fmt::format("{}: {}", path.string(), error.message()));
    return bytes;
  }
  // The output may be in the same folder, and grows.
  for (const fs::path& folder : picture_folders(path)) {
    for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
      std::error_code ignored;  // a dangling link is not read
      if (!it->is_regular_file(ignored)) continue;
      const std::uintmax_t size = it->file_size(ignored);
      if (!ignored) bytes += size;
    }
    if (error) return fail(ErrorCode::io, fmt::format("{}: {}", folder.string(), error.message()));
  }
  return bytes;
}

fs::path parts_folder(const fs::path& output) {
  fs::path normal = fs::absolute(output).lexically_normal();
  if (!normal.has_filename()) normal = normal.parent_path();
  return normal += ".parts";
}

fs::path segment_manifest(const fs::path& folder, std::uint32_t first_frame) {
  return folder / fmt::format("{:05}.json", first_frame);
}

Result<MadePlan> make_plan(const PackOptions& asked, std::vector<std::string> arguments,
                           const std::stop_token& stop) {
  if (asked.frame_time_ms) {
    return fail(ErrorCode::argument,
                "--frame-time makes the package depend on the speed of the machine, and the parts "
                "would not fit together; leave it out");
  }
  PackOptions options = asked;
  options.name = reel_name(options.name, options.output);
  CloudSequence sequence = TRY(list_cloud_frames(options.inputs, options.listing(stop)));
  if (options.keep_gaps) sequence.keep_gaps(options.fps);
  if (!options.audio) warn_of_unpacked_audio(options.inputs, sequence.warnings);
  const std::vector<CloudFrame>& frames = sequence.frames;
  PackPlan plan;
  plan.arguments = std::move(arguments);
  for (std::string& argument : reading_arguments(guessed(sequence.reading, options.reading)))
    plan.arguments.push_back(std::move(argument));
  plan.name = options.name;
  plan.up = up_of_frame(frames.front());
  plan.segment_frames = options.segment_frames;
  plan.force = options.force;
  plan.frames = TRY(planned(frames));
  if (options.audio) {
    TRY(check_audio_source(*options.audio));
    std::error_code error;
    plan.audio = fs::absolute(*options.audio, error);
    if (error) return fail(ErrorCode::io, error.message());
  }
  TRY(check_output(options));
  OutputFolder folder = TRY(plan_folder(parts_folder(options.output), options.force));
  MadePlan made{static_cast<std::uint32_t>(frames.size()),
                plan.segments(),
                {},
                std::move(sequence.warnings),
                std::move(sequence.guesses),
                {}};
  options.encode.executor = stoppable(tbb_executor(), stop, kInterrupted);
  made.trial = TRY(in_arena(options.threads, [&] {
    choose_cleaning(frames, options);
    return choose_video(frames, options, stop);
  }));
  plan.noisy = cleaning_choice(options);
  if (made.trial) {
    const Codec codec = options.video ? Codec::video : Codec::octree;
    plan.arguments.push_back(fmt::format("--codec={}", name(codec)));
    plan.segment_frames = options.segment_frames;
    made.segments = plan.segments();
  }
  if (options.train) {
    const PackageTables tables = TRY(in_arena(options.threads, [&] {
      return learn_package_tables(frames, options, folder.path(), stop);
    }));
    made.learnt = tables.learnt;
    plan.tables = tables.file;
  }
  std::string text;
  try {
    text = to_text(plan);
  } catch (const ordered_json::exception&) {
    return fail(ErrorCode::argument,
                "the name of an input file is not UTF-8, and a plan cannot hold it; rename it");
  }
  TRY(write_file(folder.path() / kPlanName, text));
  TRY(folder.publish());
  return made;
}

Result<PackPlan> read_plan(const fs::path& output) {
  const fs::path path = parts_folder(output) / kPlanName;
  if (!std::ifstream(path, std::ios::binary)) {
    return fail(ErrorCode::not_found,
                fmt::format("{}: there is no plan; make one with pack plan", path.string()));
  }
  try {
    const ordered_json json = plan_json(path);
    // Another version may encode the same frames differently.
    if (const auto by = json.at("program").get<std::string>(); by != POINTREEL_VERSION) {
      return fail(ErrorCode::unsupported,
                  fmt::format("{}: was made by version {}, and this is version {}; all parts need "
                              "the same version",
                              path.string(), visible(by), POINTREEL_VERSION));
    }
    PackPlan plan = from_json(json);
    if (plan.frames.empty()) throw std::invalid_argument("empty");
    return plan;
  } catch (const std::exception&) {
    return fail(
        fmt::format("{}: is damaged; remove its folder, and make the plan again", path.string()));
  }
}

}  // namespace pointreel
