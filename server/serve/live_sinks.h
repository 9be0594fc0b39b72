#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "server/relay/relay.h"
#include "server/serve/live_resources.h"

namespace pointreel {

/// What gets each stream that is relayed: viewers over HTTP, under /live/NAME/; and a recording, if
/// there is a folder for it. For RelayOptions::sinks. `say` is told what goes wrong.
std::function<std::vector<std::shared_ptr<LiveSink>>(const std::string& name)> live_sinks(
    std::shared_ptr<LiveResources> resources, std::optional<std::filesystem::path> record,
    std::function<void(const std::string& line)> say);

}  // namespace pointreel
