#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include <nlohmann/json.hpp>

#include "pointreel/error.h"

/// Helpers for the output of benchmarks.
namespace pointreel::bench {

/// The number with separators: 1234567 becomes "1,234,567".
std::string grouped(std::size_t n);

/// Where a benchmark writes its files unless told otherwise: below the folder of builds, so that a
/// checkout stays clean.
std::string default_folder(const std::string& benchmark);

/// Writes a file. The error begins with the name of the file.
Result<void> write_text(const std::filesystem::path& file, const std::string& text);

/// Writes a file, or to standard output if `file` is "-".
Result<void> write_json(const std::string& file, const nlohmann::json& report);

}  // namespace pointreel::bench
