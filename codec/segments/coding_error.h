#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "codec/segments/pack_frame.h"
#include "codec/segments/pack_options.h"
#include "pointreel/error.h"
#include "pointreel/package.h"

/// How far packed frames are from their sources: measured, added up, and for people and programs.
namespace pointreel {

/// The frame of a segment that is compared with its source: the middle one, if the segment contains
/// a frame whose number is a multiple of 30. Comparing takes about as long as encoding, so of many
/// short segments only some have such a frame.
std::optional<std::size_t> compared_frame(std::uint32_t first_frame, std::size_t frames);

/// Decodes the last of these frames and compares it with its source. Frames of video are those of a
/// group from its first on. Nothing if the source or what is decoded has no point.
Result<std::optional<CodingError>> coding_error(std::span<const PackedFrame> frames,
                                                const PackOptions& options);

void add_coding_error(std::optional<CodingError>& to, const CodingError& later);

/// What its PSNR is relative to: the edge of the first cube. The manifest has a segment.
double peak_of(const Manifest& manifest);
/// One line: "D1 71.3 dB, D2 ...".
std::string coding_error_text(const CodingError& error, double peak);
/// null if nobody measured it. Figures that are infinite are null, too.
nlohmann::ordered_json coding_error_json(const std::optional<CodingError>& error, double peak);

}  // namespace pointreel
