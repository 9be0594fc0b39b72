#include "server/serve/live_sinks.h"

#include <utility>

#include "pointreel/package.h"
#include "server/relay/http_window.h"
#include "server/relay/recorded_package.h"
#include "server/relay/recorder.h"
#include "server/relay/sink_thread.h"

namespace pointreel {
namespace {

/// Players ask again each time. Caches in between may answer many of them with one answer.
constexpr const char* kGrowing = "public, max-age=0, s-maxage=1";

WindowOutput output_to(const std::shared_ptr<LiveResources>& resources, const std::string& stream) {
  const std::string folder = "/live/" + stream;
  WindowOutput output;
  output.put = [resources, folder](const std::string& name, std::string content, bool immutable) {
    resources->put(folder + "/" + name,
                   text_resource(immutable ? "application/octet-stream" : "application/json",
                                 immutable ? kImmutable : kGrowing, std::move(content)));
    if (!immutable) {
      resources->put(folder, redirect_resource(folder + "/" + kManifestName));
      resources->put(folder + "/", redirect_resource(folder + "/" + kManifestName));
    }
  };
  output.remove = [resources, folder](const std::string& name) {
    resources->remove(folder + "/" + name);
    if (name != kManifestName) return;
    resources->remove(folder);
    resources->remove(folder + "/");
  };
  return output;
}

}  // namespace

std::function<std::vector<std::shared_ptr<LiveSink>>(const std::string& name)> live_sinks(
    std::shared_ptr<LiveResources> resources, std::filesystem::path record,
    std::function<void(const std::string& line)> say) {
  if (!record.empty()) complete_recordings(record, say);
  return [=](const std::string& name) {
    std::vector<std::shared_ptr<LiveSink>> sinks;
    sinks.push_back(std::make_shared<SinkThread>(
        std::make_unique<HttpWindow>(output_to(resources, name)), "served over HTTP", say));
    if (!record.empty()) {
      LiveRecorderOptions options;
      options.folder = record;
      options.name = name;
      options.say = say;
      sinks.push_back(std::make_shared<SinkThread>(
          std::make_unique<LiveRecorder>(std::move(options)), "recorded", say));
    }
    return sinks;
  };
}

}  // namespace pointreel
