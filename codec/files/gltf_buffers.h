#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "pointreel/bytes.h"
#include "pointreel/error.h"

namespace pointreel {

/// The text of a .gltf file with the buffers in it that are in files beside it, as `data:` URIs.
/// Nothing if it names no such files, or is no .gltf file. Errors name the buffer: `invalid` for
/// places outside of `folder`, be it by the path or by a link, and for what is no plain file;
/// `limit` for more than `max_bytes` altogether; `not_found`, `io`.
///
/// Trust: the text may be hostile. Nothing outside of `folder` and the folders below is read. The
/// files in there are trusted no more than the text.
Result<std::optional<Bytes>> embed_gltf_buffers(ByteView text, const std::filesystem::path& folder,
                                                std::uint64_t max_bytes);

}  // namespace pointreel
