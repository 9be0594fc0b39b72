#include "server/parts/plan.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "codec/cloud_file.h"
#include "codec/sequence/package_folder.h"
#include "common/base/output_folder.h"
#include "common/base/print.h"
#include "common/base/try.h"
#include "common/base/write_file.h"
#include "pointreel/version.h"
#include "server/pack/audio.h"
#include "server/pack/in_arena.h"
#include "server/pack/package_tables.h"

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
                       {"segment_frames", plan.segment_frames},
                       {"force", plan.force},
                       {"audio", nullptr},
                       {"tables", nullptr}};
  if (plan.audio) json["audio"] = plan.audio->string();
  if (plan.tables) {
    json["tables"] = {{"path", plan.tables->path},
                      {"bytes", plan.tables->bytes},
                      {"xxh3", checksum_text(plan.tables->checksum)}};
  }
  ordered_json& files = json["files"] = ordered_json::array();
  for (const PlannedFile& file : plan.files) files.push_back({file.path.string(), file.bytes});
  return json.dump(1) + "\n";
}

PackPlan from_json(const ordered_json& json) {
  PackPlan plan;
  plan.arguments = json.at("arguments").get<std::vector<std::string>>();
  plan.name = json.at("name").get<std::string>();
  const auto segment_frames = json.at("segment_frames").get<std::int64_t>();
  if (segment_frames < 1 || segment_frames > 100'000) throw std::invalid_argument("segment_frames");
  plan.segment_frames = static_cast<std::uint32_t>(segment_frames);
  plan.force = json.at("force").get<bool>();
  if (const ordered_json& audio = json.at("audio"); !audio.is_null())
    plan.audio = audio.get<std::string>();
  if (const ordered_json& tables = json.at("tables"); !tables.is_null()) {
    plan.tables =
        PackageFile{tables.at("path").get<std::string>(), tables.at("bytes").get<std::uint64_t>(),
                    std::stoull(tables.at("xxh3").get<std::string>(), nullptr, 16)};
    if (plan.tables->bytes > kMaxTablesBytes) throw std::invalid_argument("tables");
  }
  for (const ordered_json& file : json.at("files"))
    plan.files.push_back({file.at(0).get<std::string>(), file.at(1).get<std::uint64_t>()});
  return plan;
}

/// The output must be absent, or a package that may be replaced. Nothing is left behind.
Result<void> check_output(const PackOptions& options) {
  return OutputFolder::create(options.output,
                              options.force ? may_replace_package : OutputFolder::MayReplace{})
      .map([](const OutputFolder&) {});
}

/// Makes the empty folder of the plan.
Result<void> make_folder(const fs::path& folder, bool force) {
  std::error_code error;
  if (fs::exists(folder, error)) {
    if (!fs::exists(folder / kPlanName, error)) {
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
  if (!error) fs::create_directories(folder, error);
  if (error) {
    return fail(ErrorCode::io, fmt::format("{}: {}", folder.string(), error.message()));
  }
  return {};
}

Result<PlannedFile> planned(const fs::path& path) {
  std::error_code error;
  PlannedFile file{fs::absolute(path, error).lexically_normal(), 0};
  if (!error) file.bytes = fs::file_size(path, error);
  if (error) return fail(ErrorCode::io, fmt::format("{}: {}", path.string(), error.message()));
  return file;
}

}  // namespace

std::span<const PlannedFile> PackPlan::files_of(std::uint32_t segment) const {
  const std::size_t first = std::size_t{segment} * segment_frames;
  return std::span(files).subspan(first,
                                  std::min<std::size_t>(segment_frames, files.size() - first));
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
  if (options.name.empty()) options.name = default_reel_name(options.output);
  const std::vector<CloudFrame> files =
      TRY(list_cloud_frames(options.inputs, options.topic)).frames;
  PackPlan plan{
      std::move(arguments), options.name, options.segment_frames, options.force, {}, {}, {}};
  for (const CloudFrame& frame : files) {
    if (frame.recording != nullptr) {
      return fail(ErrorCode::argument,
                  frame.file.string() +
                      ": is a recording of many frames, which is not packed in "
                      "parts; pack it as a whole");
    }
    plan.files.push_back(TRY(planned(frame.file)));
  }
  if (options.audio) {
    TRY(check_audio_source(*options.audio));
    std::error_code error;
    plan.audio = fs::absolute(*options.audio, error);
    if (error) return fail(ErrorCode::io, error.message());
  }
  TRY(check_output(options));
  const fs::path folder = parts_folder(options.output);
  TRY(make_folder(folder, options.force));
  MadePlan made{static_cast<std::uint32_t>(files.size()), plan.segments(), {}};
  const auto complete = [&]() -> Result<void> {
    if (options.train) {
      const PackageTables tables = TRY(in_arena(
          options.threads, [&] { return learn_package_tables(files, options, folder, stop); }));
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
    return write_file(folder / kPlanName, text);
  };
  if (const Result<void> done = complete(); !done) {
    std::error_code ignored;
    fs::remove_all(folder, ignored);
    return tl::unexpected(done.error());
  }
  return made;
}

Result<PackPlan> read_plan(const fs::path& output) {
  const fs::path path = parts_folder(output) / kPlanName;
  std::ifstream in(path, std::ios::binary);
  if (!in) {
    return fail(ErrorCode::not_found,
                fmt::format("{}: there is no plan; make one with pack plan", path.string()));
  }
  const std::string text((std::istreambuf_iterator<char>(in)), {});
  try {
    const ordered_json json = ordered_json::parse(text);
    if (json.at("format") != kFormat) throw std::invalid_argument("format");
    // Another version may encode the same frames differently.
    if (const auto by = json.at("program").get<std::string>(); by != POINTREEL_VERSION) {
      return fail(ErrorCode::unsupported,
                  fmt::format("{}: was made by version {}, and this is version {}; all parts need "
                              "the same version",
                              path.string(), visible(by), POINTREEL_VERSION));
    }
    PackPlan plan = from_json(json);
    if (plan.files.empty()) throw std::invalid_argument("empty");
    return plan;
  } catch (const std::exception&) {
    return fail(fmt::format("{}: is damaged; make the plan again with --force", path.string()));
  }
}

}  // namespace pointreel
