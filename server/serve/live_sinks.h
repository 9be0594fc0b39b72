#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "server/relay/relay.h"
#include "server/service/live_resources.h"

namespace pointreel {

/// For RelayOptions::sinks: serves each stream to viewers over HTTP, under /live/NAME/, and records
/// it in the folder `record`, unless that is empty. `say` gets a line if something goes wrong.
std::function<std::vector<std::shared_ptr<LiveSink>>(const std::string& name)> live_sinks(
    std::shared_ptr<LiveResources> resources, std::filesystem::path record,
    std::function<void(const std::string& line)> say);

}  // namespace pointreel
