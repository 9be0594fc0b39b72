#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include <nlohmann/json.hpp>

#include "pointreel/error.h"

/// What every benchmark writes.
namespace pointreel::bench {

/// 1234567 as 1,234,567.
std::string grouped(std::size_t n);

/// The error begins with the file's name.
Result<void> write_text(const std::filesystem::path& file, const std::string& text);

/// To standard output for "-".
Result<void> write_json(const std::string& file, const nlohmann::json& report);

}  // namespace pointreel::bench
